//! Runs another program on the same rays, in turn with ours.
//!
//! The program is called with the name of a scene and `reps=1 buildreps=1 mt=0 threads=1`. It
//! prints a line `build,...,cpu_median=S s,...,bytes/prim=B,...` and, for each kind of rays, a line
//! `rays,KIND,threads=1,...,hit=H,cpu_median=M,...` with `M` in millions of rays per CPU second.

use anyhow::{Context, Result, bail};
use std::collections::HashMap;
use std::path::Path;
use std::process::Command;

/// The measurements of the peer.
#[derive(Clone, Debug)]
pub(super) struct Peer {
    /// Speed for each kind of rays.
    pub(super) mrays_per_second: HashMap<String, f64>,
    pub(super) build_seconds: f64,
}

/// Runs the peer once on a scene.
pub(super) fn run(program: &Path, scene: &str) -> Result<Peer> {
    let output = Command::new(program)
        .args([scene, "reps=1", "buildreps=1", "mt=0", "threads=1"])
        .output()
        .with_context(|| format!("cannot run the peer {}", program.display()))?;
    if !output.status.success() {
        let complaint = String::from_utf8_lossy(&output.stderr);
        bail!("the peer {} failed on {scene}: {}", program.display(), complaint.trim());
    }
    parse(&String::from_utf8_lossy(&output.stdout))
        .with_context(|| format!("cannot parse the output of the peer {}", program.display()))
}

fn parse(text: &str) -> Result<Peer> {
    let mut peer = Peer { mrays_per_second: HashMap::new(), build_seconds: f64::NAN };
    for line in text.lines() {
        let fields: Vec<&str> = line.split(',').collect();
        let value = |key: &str| -> Result<f64> {
            let field = fields
                .iter()
                .find_map(|field| field.strip_prefix(key)?.strip_prefix('='))
                .with_context(|| format!("no {key}= in: {line}"))?;
            let number = field.trim_end_matches(" s");
            number.parse().with_context(|| format!("{key}= is not a number in: {line}"))
        };
        match fields[..] {
            ["build", ..] => peer.build_seconds = value("cpu_median")?,
            ["rays", kind, "threads=1", ..] => {
                peer.mrays_per_second.insert(kind.to_owned(), value("cpu_median")?);
            }
            _ => {}
        }
    }
    if let Some(kind) =
        super::shoot::KINDS.iter().find(|&&kind| !peer.mrays_per_second.contains_key(kind))
    {
        bail!("no line for {kind} rays");
    }
    Ok(peer)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_a_peer_are_read() {
        let text = "scene,x,prims=1\n\
            build,x,medium,isa=default,flags=,threads=1,cpu_median=0.322 s,wall_median=0.4 s\n\
            rays,primary,threads=1,n=1,hit=0.8,cpu_median=3.5,wall_median=2.9\n\
            rays,diffuse,threads=1,n=1,hit=0.8,cpu_median=2.5,wall_median=2.9\n\
            rays,shadow,threads=1,n=1,hit=0.8,cpu_median=1.5,wall_median=2.9\n\
            rays,random,threads=1,n=1,hit=0.8,cpu_median=0.5,wall_median=2.9\n";
        let peer = parse(text).expect("all is there");
        assert_eq!(peer.build_seconds, 0.322);
        assert_eq!(peer.mrays_per_second["diffuse"], 2.5);
        let error =
            parse(&text.replace("rays,random", "ray,random")).expect_err("random is missing");
        assert!(error.to_string().contains("random"), "{error}");
    }
}
