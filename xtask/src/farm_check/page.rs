//! The examples of `docs/large-renders.md`, so that what is checked is what users read.

use crate::workspace;
use anyhow::{Context as _, Result};
use std::fs;

/// Returns the code block of the page that contains `words`.
pub(super) fn example(words: &str) -> Result<String> {
    let path = workspace::root().join("docs/large-renders.md");
    let text = fs::read_to_string(&path)
        .with_context(|| format!("cannot read {}", path.display()))?
        .replace("\r\n", "\n");
    let mut blocks = text.split("```sh\n").skip(1).filter_map(|rest| rest.split("```").next());
    let block = blocks.find(|block| block.contains(words));
    block.map(ToOwned::to_owned).with_context(|| format!("{} has no {words:?}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::example;

    #[test]
    fn the_page_has_what_the_check_runs() {
        let script = example("#SBATCH --array").expect("a script for Slurm");
        assert!(script.starts_with("#!/bin/bash\n") && script.contains("srun "), "{script}");
        let line = example("parallel ").expect("a line of GNU parallel");
        assert!(line.contains("--shard"), "{line}");
    }
}
