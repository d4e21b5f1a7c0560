//! The shard of a task of Slurm or Kubernetes.

use crate::checkpoint::Shard;
use crate::error::{Error, Result};

/// The shard of this process, from the environment variables of a Slurm array or a Kubernetes indexed job.
///
/// # Errors
/// [`Error::Usage`] if they are missing or contradict each other.
pub(crate) fn shard(
    count: Option<u32>,
    variable: impl Fn(&str) -> Option<String>,
) -> Result<Shard> {
    let number = |name: &str| -> Result<Option<u32>> {
        let parse = |text: String| {
            let wrong =
                || Error::Usage(format!("--shard auto: {name} must be a number, is `{text}`"));
            text.trim().parse().map_err(|_| wrong())
        };
        variable(name).map(parse).transpose()
    };
    let least = number("SLURM_ARRAY_TASK_MIN")?.unwrap_or(0);
    let step = number("SLURM_ARRAY_TASK_STEP")?.unwrap_or(1).max(1);
    let index = match number("SLURM_ARRAY_TASK_ID")? {
        Some(id) => {
            let steps = id.checked_sub(least).map(|steps| steps / step);
            Some(steps.ok_or_else(|| {
                let wrong = "is less than SLURM_ARRAY_TASK_MIN";
                Error::Usage(format!("--shard auto: SLURM_ARRAY_TASK_ID {id} {wrong} {least}"))
            })?)
        }
        None => number("JOB_COMPLETION_INDEX")?,
    };
    let count = match (count, number("SLURM_ARRAY_TASK_COUNT")?) {
        (Some(given), Some(tasks)) if given != tasks => {
            let message = format!("--shard auto/{given}: SLURM_ARRAY_TASK_COUNT is {tasks}");
            return Err(Error::Usage(message));
        }
        (given, tasks) => given.or(tasks),
    };
    if let (Some(most), Some(count)) = (number("SLURM_ARRAY_TASK_MAX")?, count)
        && most.checked_sub(least).is_none_or(|last| last / step + 1 != count)
    {
        // For example, tasks 0, 2 and 5 make three shards, so that index 5 is out of range.
        let message = format!("tasks {least} to {most} in steps of {step} are not {count} tasks");
        return Err(Error::Usage(format!("--shard auto: {message}: give --shard I/N")));
    }
    match (index, count) {
        (Some(index), Some(count)) if index < count => Ok(Shard { index, count }),
        (Some(index), Some(count)) => {
            Err(Error::Usage(format!("--shard auto: shard index {index} is out of range: there are {count} shards, numbered from 0")))
        }
        (Some(_), None) => Err(Error::Usage(
            "--shard auto: SLURM_ARRAY_TASK_COUNT is not set: give the number of shards with auto/N"
                .to_owned(),
        )),
        (None, _) => Err(Error::Usage(
            "--shard auto: neither SLURM_ARRAY_TASK_ID nor JOB_COMPLETION_INDEX is set".to_owned(),
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_come_from_the_environment() {
        let found = |count, variables: &[(&str, &str)]| {
            shard(count, |name| {
                variables
                    .iter()
                    .find(|(known, _)| *known == name)
                    .map(|(_, text)| (*text).to_owned())
            })
        };
        let slurm = [
            ("SLURM_ARRAY_TASK_ID", "7"),
            ("SLURM_ARRAY_TASK_MIN", "5"),
            ("SLURM_ARRAY_TASK_COUNT", "4"),
        ];
        assert_eq!(found(None, &slurm).unwrap(), Shard { index: 2, count: 4 });
        let regular = [&slurm[..], &[("SLURM_ARRAY_TASK_MAX", "8")]].concat();
        assert_eq!(found(None, &regular).unwrap(), Shard { index: 2, count: 4 });
        let steps = [("SLURM_ARRAY_TASK_STEP", "2"), ("SLURM_ARRAY_TASK_MAX", "11")];
        assert_eq!(
            found(None, &[&slurm[..], &steps].concat()).unwrap(),
            Shard { index: 1, count: 4 }
        );
        assert_eq!(
            found(Some(9), &[("JOB_COMPLETION_INDEX", "8")]).unwrap(),
            Shard { index: 8, count: 9 }
        );
        for (count, variables) in [
            (None, &slurm[..1]),
            (None, &[]),
            (Some(2), &slurm[..]),
            (Some(8), &slurm[..]),
            (Some(9), &[("SLURM_ARRAY_TASK_ID", "4"), ("SLURM_ARRAY_TASK_MIN", "5")]),
            (Some(9), &[("JOB_COMPLETION_INDEX", "x")]),
            (None, &[&slurm[..], &[("SLURM_ARRAY_TASK_MAX", "9")]].concat()),
            (None, &[&slurm[..], &[("SLURM_ARRAY_TASK_MAX", "4")]].concat()),
        ] {
            assert_eq!(found(count, variables).unwrap_err().exit_code(), 2, "{variables:?}");
        }
    }
}
