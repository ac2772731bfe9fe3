//! A campaign from its settings: environment, scheduler, and the radar with its models.

use super::environment::Environment;
use super::radar::{Radar, Station};
use super::trace::Trace;
use super::{Loop, Settings, play, scheduler};
use crate::error::{Failure, Invalid};
use crate::network::early_exits::fitted;
use crate::network::memory::OwnedMemory;
use crate::results::{Campaign, FittedExit};
use crate::scenario::Scenario;
use crate::simulator::calibration::rho_of;
use sdp3_core::dsn::Model;
use sdp3_core::early_exit::EarlyExit;
use sdp3_core::scheduler::Plan;
use std::io::{self, Write};
use std::time::Instant;

/// When sensing may end early.
pub enum Exits {
    /// Never: a period has one recognition, by the largest model that its sensing slots are enough for.
    None,
    /// At an exit of this confidence, each model with the weights that were fitted to it.
    Fitted(Vec<FittedExit>, f64),
}

/// A simulation that is over.
pub struct Simulated {
    pub campaign: Campaign,
    /// The plan of the first period.
    pub plan: Plan,
    /// How long it took in s.
    pub took_s: f64,
}

/// Simulates the periods, with these models behind the radar if there are any; the first periods go to `trace` slot by slot, in JSON for
/// Perfetto: what that file says is returned beside them.
///
/// # Errors
///
/// N_s that does not fit; models that the core refuses.
pub fn simulate(
    scenario: &Scenario,
    settings: &Settings,
    seed: u64,
    models: &[Vec<u8>],
    exits: &Exits,
    trace: impl Write,
    progress: &dyn Fn(u64, u64),
) -> Result<(Simulated, io::Result<()>), Failure> {
    let environment = Environment::new(scenario, settings, seed);
    let scheduler = scheduler(scenario, settings, &environment)?;
    let plan = scheduler.plan().clone();
    let mut trace = Trace::new(trace, &scenario.frame);
    let parsed = models.iter().map(|bytes| Model::parse(bytes)).collect::<Result<Vec<_>, _>>()?;
    let mut memory = parsed.last().map(OwnedMemory::for_model);
    let slots = match &mut memory {
        None => Loop::Schedule(Box::new(scheduler)),
        Some(memory) => {
            let (exits, threshold) = match exits {
                Exits::Fitted(exits, threshold) => {
                    let exit = |(model, exit): (&_, &FittedExit)| fitted(*model, &exit.weights);
                    (parsed.iter().zip(exits).map(exit).collect(), *threshold)
                }
                Exits::None => (vec![largest(&parsed, settings.sensing_slots)?], 2.0),
            };
            let pipeline = memory.early_exits(exits, threshold as f32)?;
            let station = Station::new(scheduler, pipeline);
            Loop::Station(Box::new(Radar::new(station, scenario, rho_of(scenario), seed)))
        }
    };
    let begun = Instant::now();
    let campaign = play(scenario, settings, environment, slots, &mut trace, progress);
    let took_s = begun.elapsed().as_secs_f64();
    Ok((Simulated { campaign, plan, took_s }, trace.finish()))
}

/// The model of most sensing slots that a period has, as the only exit.
fn largest<'m>(models: &[Model<'m>], sensing_slots: u32) -> Result<EarlyExit<'m>, Failure> {
    let fits = models.iter().filter(|m| m.sensing_slots() <= sensing_slots as usize);
    let model = fits.max_by_key(|m| m.sensing_slots());
    let model = model.ok_or_else(|| {
        let least = models.iter().map(Model::sensing_slots).min().unwrap_or(0);
        let legal = format!(
            "at least {least}, as the smallest model of --out; without the option it is that of the operating point"
        );
        Invalid::option("--sensing-slots", sensing_slots, legal)
    })?;
    Ok(EarlyExit::single(*model))
}
