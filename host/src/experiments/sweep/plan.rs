//! The plan: axes in TOML, resolved to one file that needs no other, expanded to cells.

use crate::PROGRAM;
use crate::error::{Failure, Invalid};
use crate::results::Cell;
use crate::scenario::{Class, Scenario, syntax_message};
use crate::simulator::calibration::{stored_elsewhere, stored_rho};
use crate::simulator::validity::{self, aliasing};
use crate::store::digest::sha256;
use crate::store::limited;
use crate::store::output::{Output, OutputError};
use crate::store::resume::ensure_same_config;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::fmt::Display;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Name of the resolved plan.
pub const PLAN: &str = "sweep.toml";

/// Most cells of a plan: their files are numbered with five digits.
pub const MOST_CELLS: usize = 100_000;

/// A plan. An axis that is absent is not varied: its value is each scenario's own.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    /// Name of the sweep, and of its jobs: a-z, 0-9 and -.
    #[serde(default = "unnamed")]
    pub name: String,
    /// Files of scenarios, relative to the plan's folder. Resolved, they are in `scenario`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub scenarios: Vec<PathBuf>,
    /// Carriers in Hz; absent: each scenario's `radar.carrier_hz`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub carrier_hz: Option<Vec<f64>>,
    /// AR(1) coefficients rho of the room channel; absent: each scenario's `channel.rho`, or the stored table's at the carrier.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rho: Option<Vec<f64>>,
    /// N_s; absent: each scenario's `frame.sensing_slots`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sensing_slots: Option<Vec<u32>>,
    /// Seeds; absent: the command's `--seed`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seeds: Option<Vec<u64>>,
    /// Scenarios, behind those of the files; without any, the command's `--scenario`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub scenario: Vec<Scenario>,
}

fn unnamed() -> String {
    "sweep".into()
}

/// Why a plan cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum PlanError {
    /// The file cannot be read.
    #[error("{file}: cannot be read: {source}")]
    Read {
        /// The file.
        file: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The file is not TOML, or has a key or a type that a plan does not have.
    #[error("{file}: {message}")]
    Syntax {
        /// The file.
        file: PathBuf,
        /// Line, key and the keys there are.
        message: String,
    },
    /// A field that may not be what it is.
    #[error(transparent)]
    Invalid(#[from] Invalid),
}

/// A resolved plan, expanded.
#[derive(Debug, Clone, PartialEq)]
pub struct Sweep {
    /// The plan: scenarios in it, seeds stated.
    pub plan: Plan,
    /// SHA-256 of the resolved plan.
    pub digest: String,
    /// Every cell with its scenario, which cells of other seeds share, the last axis (seeds) varying fastest.
    pub cells: Vec<(Cell, Arc<Scenario>)>,
}

impl Sweep {
    /// Reads, resolves, checks and expands a plan; `scenario` and `seed` (1) stand in for what it leaves out.
    ///
    /// # Errors
    ///
    /// [`PlanError`], and what a scenario or its motion capture says of itself.
    pub fn load(file: &Path, scenario: Option<&Scenario>, seed: Option<u64>) -> Result<Self, Failure> {
        let text = limited::read_text(file, limited::TEXT)
            .map_err(|source| PlanError::Read { file: file.to_owned(), source })?;
        let mut plan: Plan = toml::from_str(&text)
            .map_err(|error| PlanError::Syntax { file: file.to_owned(), message: syntax_message(&error) })?;
        let beside = file.parent().unwrap_or(Path::new(""));
        let read = plan.scenarios.drain(..).map(|name| Scenario::load(&beside.join(name)));
        let mut scenarios = read.collect::<Result<Vec<_>, _>>()?;
        scenarios.append(&mut plan.scenario);
        match scenario {
            Some(_) if !scenarios.is_empty() => {
                return Err(format!(
                    "command line: --scenario, --set: {} has scenarios of its own",
                    file.display()
                )
                .into());
            }
            _ if scenarios.is_empty() => scenarios.push(scenario.cloned().unwrap_or_default()),
            _ => (),
        }
        plan.scenario = scenarios;
        if let (Some(_), Some(_)) = (&plan.seeds, seed) {
            return Err(format!("command line: --seed: {} has seeds of its own", file.display()).into());
        }
        plan.seeds.get_or_insert_with(|| vec![seed.unwrap_or(1)]);
        Check { file }.plan(&plan)?;
        let cells = expand(&plan, file)?;
        let digest = sha256([format!("{PROGRAM}\n{}", plan.to_toml()).as_bytes()]);
        Ok(Sweep { plan, digest, cells })
    }

    /// Warnings of every scenario at every carrier, each once: limbs that alias, and what is wrong with a stored rho that cells use.
    pub fn warnings(&self) -> BTreeSet<String> {
        let mut words = BTreeSet::new();
        for scenario in &self.plan.scenario {
            for carrier_hz in carriers(&self.plan, scenario) {
                let mut own = scenario.clone();
                own.radar.carrier_hz = carrier_hz;
                let name = &own.name;
                words.extend(aliasing(&own, &Class::ALL).map(|aliasing| format!("{name}: {aliasing}")));
                if self.plan.rho.is_none() && own.channel.rho.is_none() {
                    words.extend(stored_elsewhere(&own));
                }
            }
        }
        words
    }

    /// The number of shards that is asked for, or else `absent`.
    ///
    /// # Errors
    ///
    /// More shards than cells.
    pub(crate) fn shards(&self, asked: Option<u32>, absent: u32) -> Result<u32, Invalid> {
        let (shards, cells) = (asked.unwrap_or(absent), self.cells.len() as u32);
        match shards <= cells {
            true => Ok(shards),
            false => Err(Invalid::option("--shards", shards, format!("1 to {cells}, the plan's cells"))),
        }
    }

    /// Begins the folder of this plan or goes on with it: [`PLAN`].
    ///
    /// # Errors
    ///
    /// [`OutputError`]: a folder of another plan, or one that cannot be used.
    pub fn open(&self, output: &Output) -> Result<(), OutputError> {
        let text = self.plan.to_toml();
        let asked = toml::from_str(&text).unwrap_or_default();
        ensure_same_config(output, PLAN, &asked, |text| toml::from_str(text).map_err(|e| e.to_string()))?;
        if !output.path(PLAN).exists() {
            output.write(PLAN, text.as_bytes())?;
        }
        Ok(())
    }
}

impl Plan {
    /// The plan as TOML.
    pub fn to_toml(&self) -> String {
        toml::to_string(self).unwrap_or_default()
    }
}

/// Every combination; each is a legal scenario.
fn expand(plan: &Plan, file: &Path) -> Result<Vec<(Cell, Arc<Scenario>)>, Failure> {
    let mut cells = Vec::new();
    for scenario in &plan.scenario {
        for (carrier, rho, slots) in combinations(plan, scenario) {
            let mut own = scenario.clone();
            own.radar.carrier_hz = carrier;
            own.frame.sensing_slots = vec![slots];
            let rho = rho.or(own.channel.rho).unwrap_or_else(|| stored_rho(&own).0);
            own.channel.rho = Some(rho);
            let origin = format!(
                "{}: {} at carrier_hz = {carrier}, rho = {rho}, sensing_slots = {slots}",
                file.display(),
                scenario.name
            );
            own.check(&origin)?;
            validity::check(&own)?;
            let own = Arc::new(own);
            for &seed in plan.seeds.iter().flatten() {
                let (index, scenario) = (cells.len() as u32, own.name.clone());
                let cell = Cell { index, scenario, carrier_hz: carrier, rho, sensing_slots: slots, seed };
                cells.push((cell, Arc::clone(&own)));
            }
        }
    }
    Ok(cells)
}

/// Carriers x rho x N_s of a scenario.
fn combinations(plan: &Plan, scenario: &Scenario) -> Vec<(f64, Option<f64>, u32)> {
    let memories = match &plan.rho {
        Some(values) => values.iter().copied().map(Some).collect(),
        None => vec![None],
    };
    let slots = plan.sensing_slots.clone().unwrap_or_else(|| scenario.frame.sensing_slots.clone());
    let mut all = Vec::new();
    for carrier in carriers(plan, scenario) {
        for &rho in &memories {
            all.extend(slots.iter().map(|&n| (carrier, rho, n)));
        }
    }
    all
}

fn carriers(plan: &Plan, scenario: &Scenario) -> Vec<f64> {
    plan.carrier_hz.clone().unwrap_or_else(|| vec![scenario.radar.carrier_hz])
}

/// Where the values came from.
struct Check<'a> {
    file: &'a Path,
}

impl Check<'_> {
    fn legal(&self, field: &str, value: impl Display, legal: bool, range: &str) -> Result<(), Invalid> {
        Invalid::unless(legal, field, value, range).map_err(|invalid| invalid.at(self.file.display()))
    }

    /// At least one value, none of them twice.
    fn axis<T: Display>(&self, field: &str, values: Option<&[T]>) -> Result<(), Invalid> {
        let Some(values) = values else { return Ok(()) };
        self.legal(field, "[]", !values.is_empty(), "at least one value, or no such key")?;
        let mut before = BTreeSet::new();
        for (k, value) in values.iter().enumerate() {
            let range = "values of which none is there twice";
            self.legal(&format!("{field}[{k}]"), value, before.insert(value.to_string()), range)?;
        }
        Ok(())
    }

    fn plan(&self, plan: &Plan) -> Result<(), Invalid> {
        let name = plan.name.as_bytes();
        let letters = name.iter().all(|b| b.is_ascii_lowercase() || b.is_ascii_digit() || *b == b'-');
        let ends = name.first().is_some_and(u8::is_ascii_lowercase) && name.last() != Some(&b'-');
        let range = "1 to 40 of a-z, 0-9 and -, a letter first and no - last";
        self.legal("name", format!("{:?}", plan.name), letters && ends && name.len() <= 40, range)?;
        self.axis("carrier_hz", plan.carrier_hz.as_deref())?;
        self.axis("rho", plan.rho.as_deref())?;
        self.axis("sensing_slots", plan.sensing_slots.as_deref())?;
        self.axis("seeds", plan.seeds.as_deref())?;
        let mut names = BTreeSet::new();
        for (k, scenario) in plan.scenario.iter().enumerate() {
            let plain = !scenario.name.contains([',', '"']);
            let first = names.insert(&scenario.name);
            let range = "a name of its own without commas and quotes";
            let field = format!("scenario[{k}].name");
            self.legal(&field, format!("{:?}", scenario.name), plain && first, range)?;
        }
        let slots = |s: &Scenario| plan.sensing_slots.as_ref().map_or(s.frame.sensing_slots.len(), Vec::len);
        let others = [
            plan.carrier_hz.as_ref().map_or(1, Vec::len),
            plan.rho.as_ref().map_or(1, Vec::len),
            plan.seeds.as_ref().map_or(1, Vec::len),
        ];
        let all = plan.scenario.iter().map(slots).fold(0, usize::saturating_add);
        let cells = others.into_iter().fold(all, usize::saturating_mul);
        let range = format!("at most {MOST_CELLS}");
        self.legal("cells (all axes multiplied)", cells, cells <= MOST_CELLS, &range)
    }
}
