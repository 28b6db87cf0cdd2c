//! Changes of files.

use std::fs;
use std::path::PathBuf;
use std::time::SystemTime;

/// Size and time of modification of a file; `None` if there is none.
type Mark = Option<(u64, SystemTime)>;

/// The files of a scene as they were when it was loaded.
#[derive(Debug)]
pub(crate) struct Watch {
    files: Vec<PathBuf>,
    loaded: Vec<Mark>,
    /// What the last look saw.
    seen: Vec<Mark>,
}

fn mark(path: &PathBuf) -> Mark {
    let data = fs::metadata(path).ok()?;
    Some((data.len(), data.modified().ok()?))
}

impl Watch {
    /// Watches files that have been read since `start`. One that was written after that counts as
    /// changed, since what was read may have been the file of before.
    pub(crate) fn new(files: Vec<PathBuf>, start: SystemTime) -> Self {
        let seen: Vec<Mark> = files.iter().map(mark).collect();
        let before = |mark: &Mark| mark.filter(|(_, modified)| *modified < start);
        Self { files, loaded: seen.iter().map(before).collect(), seen }
    }

    /// Returns true if a file has changed and all are as the last look saw them: what writes them
    /// has ended.
    pub(crate) fn has_settled_change(&mut self) -> bool {
        let now: Vec<Mark> = self.files.iter().map(mark).collect();
        let settled = now == self.seen && now != self.loaded;
        self.seen = now;
        settled
    }

    /// Takes the present state as known.
    pub(crate) fn accept(&mut self) {
        self.loaded.clone_from(&self.seen);
    }
}

#[cfg(test)]
mod tests {
    use super::Watch;
    use std::fs;
    use std::time::{Duration, SystemTime};

    #[test]
    fn a_change_counts_once_the_file_stays_as_it_is() {
        let path = std::env::temp_dir().join(format!("rotund-watch-{}", std::process::id()));
        fs::write(&path, "a").expect("written");
        let later = SystemTime::now() + Duration::from_secs(60);
        let mut watch = Watch::new(vec![path.clone()], later);
        assert!(!watch.has_settled_change(), "unchanged");
        fs::write(&path, "ab").expect("written");
        assert!(!watch.has_settled_change(), "perhaps still being written");
        assert!(watch.has_settled_change(), "as before");
        watch.accept();
        assert!(!watch.has_settled_change(), "known");
        fs::remove_file(&path).expect("removed");
        assert!(!watch.has_settled_change());
        assert!(watch.has_settled_change(), "a file that is gone has changed");
    }

    #[test]
    fn a_file_that_was_written_while_it_was_read_has_changed() {
        let path = std::env::temp_dir().join(format!("rotund-watch-late-{}", std::process::id()));
        fs::write(&path, "a").expect("written");
        let mut watch = Watch::new(vec![path.clone()], SystemTime::UNIX_EPOCH);
        assert!(watch.has_settled_change());
        fs::remove_file(&path).expect("removed");
    }
}
