//! Commands that train: `run`, `train`, `quantize`, `study`, a shard of `sweep`.

use super::context::{Context, model_name};
use super::job::{self, RunArgs, schedule_case};
use super::simulator::{measurement, rho};
use super::training::{self, QuantizeArgs, Study, StudyArgs, TrainArgs};
use crate::dataset::{Shard, Stored};
use crate::error::Failure;
use crate::experiments::RunContext;
use crate::experiments::sweep::plan::Sweep;
use crate::network::early_exits::gallery::gallery;
use crate::network::parameters::Parameters;
use crate::network::safetensors;
use crate::network::spectrograms::{Collected, Part};
use crate::optimizer::Rule;
use crate::pipeline::expected::Work;
use crate::pipeline::learn::{How, history};
use crate::pipeline::{Job, REFERENCE};
use crate::recordings::Stated;
use crate::results::{AnytimeGallery, Figures, OperatingPoint, Run, Swept, Verify};
use crate::scheduling::playback;
use crate::simulator::calibration;
use crate::store::output::Output;
use sdp3_core::early_exit::EXITS;

pub fn run(context: &Context, args: RunArgs) -> Result<bool, Failure> {
    let RunArgs { preset, resume, measured, verify } = args;
    let job = &context.job_of(preset)?;
    job.warn_of_aliasing();
    job.warn_of_few_tests();
    job.note_room();
    job.output.write("scenario.toml", job.scenario.to_toml().as_bytes())?;
    let measured = measurement(measured);
    if measured.is_none() {
        job.warn_of_rho();
    }
    let emulated = verify.targets.iter().filter(|target| *target != REFERENCE).count();
    let work = Work::Run { calibrates: measured.is_none(), emulated };
    job.say_expected(work, rho(&job.scenario), context.workers());
    let calibration = job.calibrate(measured.as_ref())?;
    // a measurement at another carrier says nothing about this one: its rho is used only at its own
    let same = (calibration.carrier_hz / job.scenario.radar.carrier_hz - 1.0).abs() < 0.2;
    let rho = match (&measured, job.scenario.channel.rho) {
        (Some(_), None) if !same => {
            job.warn_of_rho();
            calibration::stored_rho(&job.scenario).0
        }
        (Some(_), None) | (None, None) => calibration.rho,
        (_, Some(rho)) => rho,
    };
    if rho != calibration.rho {
        let text =
            format!("rho = {rho} is used: the measurement is at another carrier or the scenario gives it");
        job.progress.note("calibrate", &text);
    }
    let (shown, spectrograms) = job.gallery(rho);
    let how = How { checkpoints: true, resume, ..How::default() };
    let (learned, _) = job.learn(rho, context.workers(), how)?;
    for (bytes, n) in learned.models.iter().zip(&job.scenario.frame.sensing_slots) {
        job.output.write(&model_name(*n), bytes)?;
    }
    let (prediction, curve) = job.predict(&learned.accuracy)?;
    let rule = Rule::Weighted(job.scenario.trade.accuracy_weight);
    let outcome = job.optimize(&curve, &prediction.points, rule)?;
    let point: &OperatingPoint = &outcome.operating_point;
    let schedule = job.play(point, rho, &learned.models)?;
    let plans = outcome.region.iter().map(|p| playback::plan(p, point)).collect::<Result<_, _>>()?;
    let anytime = classify_gallery(job, rho, &learned.models, point, &shown)?;
    let mut result = Run {
        scenario: job.scenario.name.clone(),
        seed: job.seed,
        rho,
        accuracy: learned.accuracy,
        curve,
        verify: Verify { compared: 0, mismatches: 0, targets: Vec::new() },
        region: outcome.region.clone(),
        operating_point: point.clone(),
        schedule,
        report: "report.html".into(),
    };
    let suite = job.suite(rho, &learned.models, schedule_case(&result))?;
    result.verify = job.verify(&suite, &verify.targets, verify.firmware.as_deref())?;
    let figures = Figures {
        classes: crate::scenario::Class::ALL.iter().map(|c| c.name().to_owned()).collect(),
        spectrograms,
        calibration,
        training: learned.training,
        confusion: learned.confusion,
        prediction,
        weighted: outcome.weighted,
        cases: outcome.cases,
        plans,
        anytime,
    };
    job.output.write_result("run.json", &result)?;
    job.output.write_result("figures.json", &figures)?;
    let page = job::page(job, &result, &figures)?;
    context.print(&result, || format!("{}\nreport: {}", job::table(&result.verify), page.display()))?;
    Ok(result.verify.mismatches == 0)
}

/// The gallery with early exits at the operating point's accuracy, fitted on as many recordings as are tested.
fn classify_gallery(
    job: &Job,
    rho: f64,
    models: &[Vec<u8>],
    point: &OperatingPoint,
    shown: &Collected,
) -> Result<Option<AnytimeGallery>, Failure> {
    let stage = job.progress.stage("early exits", "the gallery's recordings");
    let calibration = job.recordings(rho, Part::Calibration, job.scenario.learning.test_per_class);
    let found = gallery(models, &calibration, point.accuracy, shown, &|done, all| stage.at(done, all))?;
    stage.finish(&match &found {
        Some(found) => {
            let slots: Vec<u32> = found.recordings.iter().map(|r| r.stops_after).collect();
            format!("the gallery's recordings stop after {slots:?} slots")
        }
        None => format!("no early exits: at most {EXITS} exits, {} networks", models.len()),
    });
    Ok(found)
}

pub fn train(context: &Context, args: TrainArgs) -> Result<bool, Failure> {
    use crate::network::recipe::Recipe;
    use crate::network::training::Backend;
    let backend = match args.backend {
        training::Backend::Flex => Backend::Flex,
        #[cfg(feature = "wgpu")]
        training::Backend::Wgpu => Backend::Wgpu,
        #[cfg(feature = "cuda")]
        training::Backend::Cuda => Backend::Cuda,
        #[cfg(not(all(feature = "wgpu", feature = "cuda")))]
        other => {
            let name = format!("{other:?}").to_lowercase();
            return Err(format!("--backend {name}: build it with the feature `{name}`").into());
        }
    };
    let mut job = context.job_of(args.preset)?;
    if let Some(recipe) = args.recipe {
        let recipe = match recipe {
            training::Recipe::AdamwOneCycle => Recipe::AdamwOneCycle,
            training::Recipe::PaperAdam => Recipe::PaperAdam,
            training::Recipe::PaperMomentum => Recipe::PaperMomentum,
        };
        recipe.apply(&mut job.scenario.learning);
    }
    let images = match &args.data {
        Some(folder) => {
            let stored = Stored::open(folder)?;
            let asked = job.scenario.learning.windows;
            job.scenario = stored.scenario(&job.scenario, context.given())?;
            if job.scenario.learning.windows != asked {
                let slots = stored.slots();
                let text =
                    format!("recordings of {slots} slots have no room for {asked} windows: one of each");
                job.progress.note("read", &text);
            }
            job.collect_stored(&stored)?
        }
        None => {
            job.warn_of_rho();
            job.say_expected(Work::Train, rho(&job.scenario), context.workers());
            simulated(&job)
        }
    };
    let how = How { backend, checkpoints: true, resume: args.resume };
    let trained = job.train(&images, context.workers(), how)?;
    job.output.write("training.csv", history(&trained.training).as_bytes())?;
    for (parameters, n) in trained.parameters.iter().zip(&job.scenario.frame.sensing_slots) {
        job.output.write_json(&format!("models/dsn-{n}.json"), parameters)?;
    }
    job.output.write_json("training.json", &trained.training)?;
    context.print(&trained.training, String::new)?;
    Ok(true)
}

/// Images of the training recordings that a scenario asks for.
fn simulated(job: &Job) -> Collected {
    job.collect(rho(&job.scenario), Part::Train, "training recordings")
}

pub fn quantize(context: &Context, args: QuantizeArgs) -> Result<bool, Failure> {
    const TRAIN_FIRST: &str = "`sdp3 train` with the same --out makes it";
    let mut job = context.job()?;
    job.scenario = context.resolved(&job)?;
    let networks = job
        .scenario
        .frame
        .sensing_slots
        .iter()
        .map(|n| {
            let name = format!("models/dsn-{n}.json");
            let network: Parameters = job.output.read_json(&name, TRAIN_FIRST)?;
            let checked = safetensors::check(&network);
            checked.map_err(|e| format!("{}: {e}", job.output.path(&name).display()))?;
            Ok(network)
        })
        .collect::<Result<Vec<_>, Failure>>()?;
    let images = match &args.data {
        Some(folder) => {
            let stored = Stored::open(folder)?;
            stored.scenario(&job.scenario, true)?;
            job.collect_stored(&stored)?
        }
        None => simulated(&job),
    };
    let models = job.quantize(&networks, &images)?;
    let mut files = Vec::new();
    for (bytes, n) in models.iter().zip(&job.scenario.frame.sensing_slots) {
        files.push(job.output.write(&model_name(*n), bytes)?);
    }
    context.print_files(&files)?;
    Ok(true)
}

pub fn study(context: &Context, args: StudyArgs) -> Result<bool, Failure> {
    use crate::experiments::cells::Cells;
    use crate::experiments::{Request, baselines, fidelity, labelled, learning_curve, robustness};
    let StudyArgs { name, seeds, measured, carrier, rate } = args;
    if measured.is_some() && name != Study::Fidelity {
        return Err("command line: --measured belongs to the study fidelity".into());
    }
    let job = context.job()?;
    let name_of = |name: Study| clap::ValueEnum::to_possible_value(&name).map(|v| v.get_name().to_owned());
    let study = name_of(name).unwrap_or_default();
    let request = Request { study, seed: job.seed, seeds, scenario: job.scenario.clone() };
    let cells = Cells::open(&job.output, &request)?;
    job.warn_of_few_tests();
    job.warn_of_rho();
    let run_context = RunContext { progress: job.progress, workers: context.workers() };
    match name {
        Study::LearningCurve => {
            let found = learning_curve::study(&request, &cells, run_context)?;
            context.draw(&job, "learning-curve", &crate::report::studies::learning_curve(&found))?;
            context.print(&found, || learning_curve::table(&request, &found))?;
        }
        Study::Robustness => {
            let found = robustness::study(&request, &cells, run_context)?;
            context.draw(&job, "robustness", &crate::report::studies::robustness(&found))?;
            context.print(&found, || robustness::table(&request, &found))?;
        }
        Study::Fidelity => {
            let stated = Stated { carrier_hz: carrier, rate_hz: rate, ..Stated::default() };
            let recordings = match measured {
                Some(folder) => labelled::read(&folder, &stated)?,
                None => Default::default(),
            };
            let found = fidelity::study(&request, &cells, recordings, run_context)?;
            for (name, svg) in crate::report::fidelity::pictures(&found) {
                context.draw(&job, &name, &svg)?;
            }
            context.print(&found, || fidelity::table(&request, &found))?;
        }
        Study::Baselines => {
            let found = baselines::study(&request, &cells, run_context)?;
            context.draw(&job, "baselines", &crate::report::studies::baselines(&found))?;
            context.print(&found, || baselines::table(&request, &found))?;
        }
    }
    Ok(true)
}

pub fn shard(context: &Context, sweep: &Sweep, shard: Shard) -> Result<Swept, Failure> {
    let run_context = RunContext { progress: context.progress, workers: context.workers() };
    crate::experiments::sweep::run::run(sweep, shard, &Output::create(&context.common.out)?, run_context)
}
