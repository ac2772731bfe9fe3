//! Which recordings a cross-validation tests together: persons, or where they are not known recordings, as wholes.

use crate::error::Invalid;
use crate::network::parameters::shuffled;
use crate::recordings::labels::Labelled;
use std::collections::{BTreeMap, BTreeSet};

/// The fold of every recording, from 0: groups in random order, those of the same classes spread over the folds.
///
/// # Errors
///
/// A class that is in one fold alone.
pub fn folds(labelled: &[Labelled], most: usize, seed: u64, origin: &str) -> Result<Vec<usize>, Invalid> {
    let mut groups: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for l in labelled {
        groups.entry(l.group()).or_default().insert(&l.class);
    }
    let groups: Vec<_> = groups.into_iter().collect();
    let mut order = shuffled(groups.len(), seed, 0);
    order.sort_by_key(|&g| &groups[g].1);
    let count = most.min(groups.len());
    let fold_of: BTreeMap<&str, usize> =
        order.iter().enumerate().map(|(place, &g)| (groups[g].0, place % count.max(1))).collect();
    let fold_of = |l: &Labelled| fold_of.get(l.group()).copied().unwrap_or(0);
    for l in labelled {
        let of_class: BTreeSet<usize> =
            labelled.iter().filter(|other| other.class == l.class).map(fold_of).collect();
        let legal = "at least 2 recordings, or persons: one to learn from, one to test with";
        Invalid::unless(of_class.len() >= 2, format!("class {}", l.class), "1 recording or person", legal)
            .map_err(|invalid| invalid.at(origin))?;
    }
    Ok(labelled.iter().map(fold_of).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_person_is_in_one_fold_and_every_class_in_several() {
        let all: Vec<Labelled> = (0..24)
            .map(|n| {
                Labelled::example(
                    &format!("{n}"),
                    ["sit", "fall"][n % 2],
                    Some(["a", "b", "c", "d", "e", "f"][n / 4]),
                )
            })
            .collect();
        for most in [2, 3, 5, 100] {
            let found = folds(&all, most, 1, "here").unwrap();
            for group in all.chunks(4).zip(found.chunks(4)) {
                assert!(group.1.iter().all(|fold| *fold == group.1[0]), "{group:?}");
            }
            assert_eq!(found.iter().collect::<BTreeSet<_>>().len(), most.min(6));
        }
        // two recordings of each of five classes, each class in two of the five folds
        let few: Vec<Labelled> =
            (0..10).map(|n| Labelled::example(&format!("{n}"), &format!("class {}", n / 2), None)).collect();
        let found = folds(&few, 5, 1, "here").unwrap();
        assert!(found.chunks(2).all(|pair| pair[0] != pair[1]), "{found:?}");
        let lonely = [
            Labelled::example("1", "sit", Some("a")),
            Labelled::example("2", "sit", Some("b")),
            Labelled::example("3", "fall", Some("a")),
        ];
        assert!(folds(&lonely, 5, 1, "here").unwrap_err().to_string().contains("class fall"));
    }
}
