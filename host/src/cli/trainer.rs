//! Commands that train: `run`, `train`, `quantize`, `study`.

use super::context::{Context, Preset};
use super::job::{self, RunArgs};
use super::simulator::measurement;
use super::training::{self, Items, QuantizeArgs, ReproduceArgs, StudyArgs, TrainArgs};
use crate::error::Failure;
use crate::network::recipe::Recipe;
use crate::network::training::Backend;
use crate::pipeline::main_job::MainJob;
use crate::pipeline::reproduce::Reproduce;
use crate::pipeline::train::Train;
use crate::pipeline::train_recordings::{Method, Source};
use crate::recordings::Stated;
use crate::report::recordings::learned;
use crate::results::Reproduction;

pub fn run(context: &Context, args: RunArgs) -> Result<bool, Failure> {
    let RunArgs { preset, resume, measured, verify } = args;
    let (quick, measured) = (preset == Preset::Quick, measurement(measured, context.common.budget()));
    let ask = MainJob { quick, resume, measured, targets: verify.targets()? };
    let (run, page) = context.job()?.main_job(&ask)?;
    context.print(&run, || format!("{}\nreport: {}", job::table(&run.verify), page.display()))?;
    Ok(run.verify.mismatches == 0)
}

pub fn train(context: &Context, args: TrainArgs) -> Result<bool, Failure> {
    let TrainArgs {
        preset,
        data,
        recordings,
        method,
        folds,
        hold_out_classes,
        stated,
        recipe,
        resume,
        backend,
    } = args;
    let name = format!("{backend:?}").to_lowercase();
    let backend = Backend::named(&name)
        .ok_or_else(|| format!("--backend {name}: build it with the feature `{name}`"))?;
    backend.ready()?;
    let recipe = recipe.map(|recipe| match recipe {
        training::Recipe::AdamwOneCycle => Recipe::AdamwOneCycle,
        training::Recipe::PaperAdam => Recipe::PaperAdam,
        training::Recipe::PaperMomentum => Recipe::PaperMomentum,
    });
    let ask = Train { quick: preset == Preset::Quick, data, recipe, resume, backend };
    if let Some(folder) = recordings {
        let method = match method {
            training::Method::Recordings => Method::Recordings,
            training::Method::WithSimulation => Method::WithSimulation,
            training::Method::FineTuning => Method::FineTuning,
        };
        let stated = stated.stated(context.common.budget());
        let (job, origin) = (context.job()?, folder.display().to_string());
        let labelled = job.labelled(&folder)?;
        let source = Source { labelled, origin, stated, method, folds: folds as usize, hold_out_classes };
        let (found, _) = job.train_recordings(&ask, source)?;
        context.print(&found, || learned(&found))?;
        return Ok(true);
    }
    let found = context.job()?.train_networks(&ask)?;
    context.print(&found, String::new)?;
    Ok(true)
}

pub fn quantize(context: &Context, args: &QuantizeArgs) -> Result<bool, Failure> {
    let files = context.job()?.quantize_networks(args.data.as_deref())?;
    context.print_files(&files)?;
    Ok(true)
}

pub fn reproduce(context: &Context, args: ReproduceArgs) -> Result<bool, Failure> {
    let ReproduceArgs { items, size, seeds, measured, carrier, shard } = args;
    let budget = context.common.budget();
    let stated = Stated { carrier_hz: carrier, budget, ..Stated::default() };
    let measured = measured.map(|folder| (folder, stated));
    let items = Items::named(&items);
    let found = context.job()?.reproduce(&Reproduce { items, size, seeds, measured, shard })?;
    context.print(&found, || {
        let line = |r: &Reproduction| {
            format!("{:22} as printed: {}; here: {}", r.item, r.verdict_as_printed, r.verdict)
        };
        found.iter().map(line).collect::<Vec<_>>().join("\n")
    })?;
    Ok(true)
}

pub fn study(context: &Context, args: &StudyArgs) -> Result<bool, Failure> {
    let budget = context.common.budget();
    let stated = Stated { carrier_hz: args.carrier, rate_hz: args.rate, budget, ..Stated::default() };
    let measured = args.measured.as_deref().map(|folder| (folder, &stated));
    let (request, found) = context.job()?.study(args.name, args.seeds, measured)?;
    context.print(&found, || found.table(&request))?;
    Ok(true)
}
