//! States the commit that the program is built of, and its date: `SDP3_COMMIT` and `SDP3_DATE` of the environment, or else git's.

use std::path::Path;
use std::process::Command;

/// What git says in this package's folder; `None` without git, or where it does not know the package.
fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).current_dir(env!("CARGO_MANIFEST_DIR")).output().ok()?;
    let text = String::from_utf8(output.stdout).ok().filter(|_| output.status.success())?;
    Some(text.trim().to_owned())
}

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    // a copy of the package within another repository is not of that repository's commit
    let known = git(&["ls-files", "--error-unmatch", "build.rs"]).is_some();
    let stated = [("SDP3_COMMIT", "--format=%H"), ("SDP3_DATE", "--format=%cs")].map(|(name, format)| {
        println!("cargo::rerun-if-env-changed={name}");
        let of_git = || known.then(|| git(&["log", "-1", format])).flatten();
        let value = std::env::var(name).ok().or_else(of_git)?;
        println!("cargo::rustc-env={name}={value}");
        Some(value)
    });
    let mut version = env!("CARGO_PKG_VERSION").to_owned();
    if let [Some(commit), Some(date)] = &stated {
        let short: String = commit.chars().take(12).collect();
        version += &format!(" (commit {short}, {date})");
    }
    println!("cargo::rustc-env=SDP3_VERSION={version}");
    // it has a line for every commit and every checkout
    let log = known.then(|| git(&["rev-parse", "--git-path", "logs/HEAD"])).flatten();
    if let Some(log) = log.filter(|log| Path::new(log).exists()) {
        println!("cargo::rerun-if-changed={log}");
    }
}
