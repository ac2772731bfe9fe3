//! Which shard of a sweep a process makes: the command line says, else Slurm's or Kubernetes' environment, else it makes all.
//!
//! Slurm: `SLURM_ARRAY_TASK_ID` within `SLURM_ARRAY_TASK_MIN`, `_STEP` and `_COUNT` of an array such as `--array=1-8`.
//! Kubernetes: `JOB_COMPLETION_INDEX` of an Indexed Job, from 0, and [`COMPLETIONS`], which the job must set: Kubernetes does not.

use crate::dataset::Shard;
use crate::error::Invalid;

/// Says how many completions an Indexed Job has.
pub const COMPLETIONS: &str = "JOB_COMPLETIONS";

const TASK: &str = "SLURM_ARRAY_TASK_ID";
const COUNT: &str = "SLURM_ARRAY_TASK_COUNT";
const LEAST: &str = "SLURM_ARRAY_TASK_MIN";
const STEP: &str = "SLURM_ARRAY_TASK_STEP";
const INDEX: &str = "JOB_COMPLETION_INDEX";

/// Why the environment names no shard.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ShardError {
    /// A field that may not be what it is.
    #[error(transparent)]
    Invalid(#[from] Invalid),
    /// Slurm and Kubernetes say different things.
    #[error(
        "environment: {TASK} says shard {slurm}, {INDEX} says shard {kubernetes}; --shard I/N settles it"
    )]
    Both { slurm: Shard, kubernetes: Shard },
}

/// A shard and what should be said about it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Choice {
    pub shard: Shard,
    /// A conflict that the command line settled.
    pub conflict: Option<String>,
}

/// The shard that `asked`, the command line, says, else `variable`, the environment; else all.
///
/// # Errors
///
/// [`ShardError`], unless the command line says.
pub fn choose(asked: Option<Shard>, variable: impl Fn(&str) -> Option<String>) -> Result<Choice, ShardError> {
    let around = environment(&variable);
    let Some(shard) = asked else {
        return Ok(Choice { shard: around?.unwrap_or(Shard::ALL), conflict: None });
    };
    let conflict = match around {
        Ok(Some(other)) if other != shard => {
            Some(format!("--shard {shard} is made, although the environment says {other}"))
        }
        Err(error) => Some(format!("--shard {shard} is made; {error}")),
        _ => None,
    };
    Ok(Choice { shard, conflict })
}

fn refused(name: &str, value: impl std::fmt::Display, legal: String) -> ShardError {
    let legal = format!("{legal}; --shard I/N says it on the command line");
    Invalid::new(name, value, legal).at("environment").into()
}

fn environment(variable: &impl Fn(&str) -> Option<String>) -> Result<Option<Shard>, ShardError> {
    match (slurm(variable)?, kubernetes(variable)?) {
        (Some(slurm), Some(kubernetes)) if slurm != kubernetes => Err(ShardError::Both { slurm, kubernetes }),
        (slurm, kubernetes) => Ok(slurm.or(kubernetes)),
    }
}

fn slurm(variable: &impl Fn(&str) -> Option<String>) -> Result<Option<Shard>, ShardError> {
    let Some(task) = number(TASK, variable(TASK), 0)? else { return Ok(None) };
    let count = required(COUNT, variable(COUNT), 1)?;
    let least = required(LEAST, variable(LEAST), 0)?;
    let step = number(STEP, variable(STEP), 1)?.unwrap_or(1);
    let past = task.checked_sub(least).filter(|past| past % step == 0).map(|past| past / step);
    let shard = past.and_then(|past| past.checked_add(1)).and_then(|index| Shard::new(index, count));
    let legal = || format!("one of {count} numbers from {least} on, {step} apart");
    shard.map(Some).ok_or_else(|| refused(TASK, task.to_string(), legal()))
}

fn kubernetes(variable: &impl Fn(&str) -> Option<String>) -> Result<Option<Shard>, ShardError> {
    let Some(index) = number(INDEX, variable(INDEX), 0)? else { return Ok(None) };
    let count = required(COMPLETIONS, variable(COMPLETIONS), 1)?;
    let shard = index.checked_add(1).and_then(|index| Shard::new(index, count));
    let legal = || format!("0 to {}, below {COMPLETIONS}", count - 1);
    shard.map(Some).ok_or_else(|| refused(INDEX, index.to_string(), legal()))
}

fn required(name: &'static str, text: Option<String>, least: u32) -> Result<u32, ShardError> {
    let absent = || refused(name, "missing", range(least));
    number(name, text, least)?.ok_or_else(absent)
}

fn number(name: &'static str, text: Option<String>, least: u32) -> Result<Option<u32>, ShardError> {
    let Some(text) = text else { return Ok(None) };
    let found = text.trim().parse().ok().filter(|number| *number >= least);
    found.map(Some).ok_or_else(|| refused(name, format!("{text:?}"), range(least)))
}

fn range(least: u32) -> String {
    format!("{least} to {}", u32::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn choice(asked: Option<&str>, variables: &[(&str, &str)]) -> Result<Choice, ShardError> {
        let asked = asked.map(|text| text.parse().unwrap());
        choose(asked, |name| variables.iter().find(|(n, _)| *n == name).map(|(_, v)| (*v).to_owned()))
    }

    fn shard(variables: &[(&str, &str)]) -> String {
        choice(None, variables).unwrap().shard.to_string()
    }

    #[test]
    fn slurm_and_kubernetes_count_their_own_ways() {
        assert_eq!(shard(&[]), "1/1");
        assert_eq!(shard(&[(TASK, "3"), (COUNT, "8"), (LEAST, "1")]), "3/8");
        assert_eq!(shard(&[(TASK, "0"), (COUNT, "8"), (LEAST, "0")]), "1/8");
        assert_eq!(shard(&[(TASK, "14"), (COUNT, "3"), (LEAST, "10"), (STEP, "2")]), "3/3");
        assert_eq!(shard(&[(INDEX, "7"), (COMPLETIONS, "8")]), "8/8");
        assert_eq!(
            shard(&[(INDEX, "2"), (COMPLETIONS, "8"), (TASK, "3"), (COUNT, "8"), (LEAST, "1")]),
            "3/8"
        );
    }

    #[test]
    fn what_names_no_shard_is_refused_by_its_variable() {
        let refused = |variables: &[(&str, &str)], words: &[&str]| {
            let error = choice(None, variables).unwrap_err().to_string();
            words.iter().for_each(|word| assert!(error.contains(word), "{word:?} is not in: {error}"));
        };
        refused(&[(TASK, "3"), (LEAST, "1")], &[COUNT, "missing", "1 to "]);
        refused(&[(TASK, "3"), (COUNT, "8")], &[LEAST, "missing"]);
        refused(&[(TASK, "3"), (COUNT, "0"), (LEAST, "1")], &[COUNT, "\"0\"", "1 to "]);
        refused(
            &[(TASK, "9"), (COUNT, "8"), (LEAST, "1")],
            &["SLURM_ARRAY_TASK_ID is 9", "one of 8 numbers from 1"],
        );
        refused(&[(TASK, "7"), (COUNT, "3"), (LEAST, "1"), (STEP, "4")], &["4 apart", "--shard"]);
        refused(&[(INDEX, "x"), (COMPLETIONS, "8")], &[INDEX, "\"x\"", "0 to "]);
        refused(&[(INDEX, "8"), (COMPLETIONS, "8")], &["JOB_COMPLETION_INDEX is 8", "0 to 7"]);
        refused(&[(INDEX, "1")], &[COMPLETIONS, "missing"]);
        refused(
            &[(INDEX, "2"), (COMPLETIONS, "4"), (TASK, "2"), (COUNT, "4"), (LEAST, "1")],
            &["2/4", "3/4"],
        );
    }

    #[test]
    fn the_command_line_wins_and_says_so() {
        let same = choice(Some("3/8"), &[(TASK, "3"), (COUNT, "8"), (LEAST, "1")]).unwrap();
        assert_eq!((same.shard.to_string().as_str(), same.conflict), ("3/8", None));
        let other = choice(Some("1/2"), &[(TASK, "3"), (COUNT, "8"), (LEAST, "1")]).unwrap();
        assert_eq!(other.shard.to_string(), "1/2");
        let text = other.conflict.unwrap();
        assert!(text.contains("1/2") && text.contains("3/8"), "{text}");
        assert!(choice(Some("1/2"), &[(TASK, "3")]).unwrap().conflict.unwrap().contains(COUNT));
    }
}
