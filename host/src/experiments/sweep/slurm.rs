//! Slurm: an array job with a task a shard, and a merge that starts when all of them have succeeded.
//!
//! A task with a killed program (SIGKILL: by an operator, or for want of memory) is queued again, [`RESTARTS`] times at most, and
//! so is one on a node that goes down; it goes on with the cells that are missing. Bad input (exit code 2) is not tried again, nor is
//! what was interrupted on purpose.

use super::plan::{PLAN, Sweep};
use crate::error::{Failure, Invalid};
use crate::results::Submitted;
use crate::store::output::Output;
use crate::text::is_printable;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Times a killed task is queued again.
pub const RESTARTS: u32 = 3;

/// Folder of the jobs' logs.
const LOGS: &str = "logs";

/// Either word, anywhere in a line of options, begins another component of a heterogeneous job.
const COMPONENT_SEPARATORS: [&str; 2] = ["hetjob", "packjob"];

/// The scripts of a sweep.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Jobs {
    shards: u32,
    array: PathBuf,
    merge: PathBuf,
}

/// Writes the resolved plan and both scripts to a folder that all nodes see under the same path.
///
/// # Errors
///
/// A folder of another sweep, or one that cannot be written; an option that is none.
pub fn write(sweep: &Sweep, shards: u32, options: &[String], output: &Output) -> Result<Jobs, Failure> {
    let separates = |text: &str| COMPONENT_SEPARATORS.iter().any(|word| text.contains(word));
    let option = |text: &str| text.starts_with('-') && text.chars().all(is_printable) && !separates(text);
    if let Some(bad) = options.iter().find(|text| !option(text)) {
        let legal = "an option of sbatch, without hetjob and packjob";
        return Err(Invalid::option("--sbatch", format!("{bad:?}"), legal).into());
    }
    let name = &sweep.plan.name;
    Invalid::unless(
        !separates(name),
        "name",
        format!("{name:?}"),
        "a name without hetjob and packjob for Slurm",
    )
    .map_err(|invalid| invalid.at("plan"))?;
    let (folder, program) = (output.folder().canonicalize()?, std::env::current_exe()?);
    for (field, path) in [("--out", &folder), ("path of sdp3", &program)] {
        // a line of `#SBATCH` ends at a line break, and a word of it at a quotation mark
        let plain = path.to_str().is_some_and(|path| {
            path.chars().all(|c| is_printable(c) && !matches!(c, '"' | '\\')) && !separates(path)
        });
        let legal = "a path of printable characters without \" and \\, and without hetjob and packjob";
        Invalid::unless(plain, field, format!("{path:?}"), legal)
            .map_err(|invalid| invalid.at("command line"))?;
    }
    sweep.open(output)?;
    std::fs::create_dir_all(folder.join(LOGS))?;
    let head = |name: &str, log: &str, more: &str| {
        let log = folder.join(LOGS).display().to_string().replace('%', "%%") + "/" + log;
        let options: String = options.iter().map(|option| format!("#SBATCH {option}\n")).collect();
        format!(
            "#!/bin/sh\n#SBATCH --job-name={name}\n#SBATCH --output=\"{log}\"\n#SBATCH --open-mode=append\n{more}{options}"
        )
    };
    let array = format!(
        "{}echo \"shard $SLURM_ARRAY_TASK_ID of {shards}, run ${{SLURM_RESTART_COUNT:-0}}, on $SLURMD_NODENAME\"\n\
         {program} sweep {plan} --out {out} --threads \"${{SLURM_CPUS_ON_NODE:-0}}\"\n\
         code=$?\n\
         # killed: queued again, and what is done is kept\n\
         if [ \"$code\" = 137 ] && [ \"${{SLURM_RESTART_COUNT:-0}}\" -lt {RESTARTS} ]; then\n    \
         scontrol requeue \"$SLURM_JOB_ID\"\n\
         fi\n\
         exit \"$code\"\n",
        head(name, "shard-%a.log", &format!("#SBATCH --array=1-{shards}\n#SBATCH --requeue\n")),
        program = quoted(&program),
        plan = quoted(&folder.join(PLAN)),
        out = quoted(&folder),
    );
    let merge = format!(
        "{}exec {} merge {}\n",
        head(&format!("{name}-merge"), "merge.log", ""),
        quoted(&program),
        quoted(&folder)
    );
    Ok(Jobs {
        shards,
        array: output.write("sweep.sbatch", array.as_bytes())?,
        merge: output.write("merge.sbatch", merge.as_bytes())?,
    })
}

impl Jobs {
    /// Their files, not submitted.
    pub fn written(&self) -> Submitted {
        let files = [&self.array, &self.merge].map(|file| file.display().to_string()).to_vec();
        Submitted { shards: self.shards, files, array: None, merge: None }
    }

    /// Hands both to `sbatch`.
    ///
    /// # Errors
    ///
    /// No `sbatch`, or what it says. Where the array is submitted and the merge is not, the message says how to.
    pub fn submit(&self) -> Result<Submitted, Failure> {
        let array = sbatch(&[], &self.array)?;
        let after = format!("--dependency=afterok:{array}");
        let merge = sbatch(&[&after, "--kill-on-invalid-dep=yes"], &self.merge).map_err(|error| {
            format!(
                "{error}; array job {array} is submitted: `sbatch {after} {}` adds the merge",
                self.merge.display()
            )
        })?;
        Ok(Submitted { array: Some(array), merge: Some(merge), ..self.written() })
    }
}

/// Submits a script; the job's number.
fn sbatch(options: &[&str], script: &Path) -> Result<String, Failure> {
    let mut command = Command::new("sbatch");
    command.arg("--parsable").args(options).arg(script);
    let output = command.output().map_err(|error| {
        format!("sbatch: {error}; on a machine without Slurm, --dry-run writes {} only", script.display())
    })?;
    if !output.status.success() {
        let text = String::from_utf8_lossy(&output.stderr);
        return Err(format!("sbatch {}: {}: {}", script.display(), output.status, text.trim()).into());
    }
    // NUMBER, or NUMBER;CLUSTER
    let text = String::from_utf8_lossy(&output.stdout);
    Ok(text.trim().split(';').next().unwrap_or_default().to_owned())
}

/// A path as one word of a shell.
fn quoted(path: &Path) -> String {
    format!("'{}'", path.display().to_string().replace('\'', "'\\''"))
}
