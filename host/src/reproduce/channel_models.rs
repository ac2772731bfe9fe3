//! Table I: which channel model has which property, each decided by an experiment.

use super::made::{Made, statement};
use super::work::{Task, Work};
use crate::error::Failure;

pub fn tasks(seeds: &[u64]) -> Vec<Task> {
    seeds.iter().map(|&seed| Task::Properties { seed }).collect()
}

pub fn make(work: &Work<'_>) -> Result<Made, Failure> {
    let tables: Vec<_> = work.seeds.iter().map(|&seed| work.properties(seed)).collect::<Result<_, _>>()?;
    let mut made = Made { caption: "A comparison of channel models (Table I)", ..Made::default() };
    let (mut all, mut equal) = (0, 0);
    let mut complete = Vec::new();
    for model in &tables[0].models {
        // a property holds if it does with every seed
        let holds = |property: &str| {
            let verdicts = tables.iter().filter_map(|table| {
                let row = table.models.iter().find(|row| row.name == model.name)?;
                row.properties[property].verdict
            });
            let verdicts: Vec<bool> = verdicts.collect();
            (verdicts.len() == tables.len()).then(|| verdicts.iter().all(|&holds| holds))
        };
        let found: Vec<_> = model.properties.iter().map(|(name, p)| (name, p, holds(name))).collect();
        if found.iter().all(|(.., holds)| *holds == Some(true)) {
            complete.push(model.name.clone());
        }
        for (name, property, holds) in found {
            let Some(paper) = property.paper else { continue };
            all += 1;
            equal += u32::from(holds == Some(paper));
            if holds != Some(paper) {
                let words = |holds: Option<bool>| match holds {
                    Some(true) => "yes",
                    Some(false) => "no",
                    None => "not defined by its standard",
                };
                made.notes.push(format!(
                    "{}, {}: the paper {}, here {}. {}",
                    model.name,
                    name.replace('_', " "),
                    words(Some(paper)),
                    words(holds),
                    property.reason
                ));
            }
        }
    }
    // the table does not depend on the settings: it has scenes of its own
    let dahc = Some(complete.iter().any(|name| name == "dahc"));
    let alone = Some(complete == ["dahc"]);
    made.statements = vec![
        statement("the hybrid channel has every property", [None, dahc]),
        statement("no other model has them all", [None, alone]),
        statement(
            &format!("every mark of the table ({equal} of {all} are equal)"),
            [None, Some(equal == all)],
        ),
    ];
    Ok(made)
}
