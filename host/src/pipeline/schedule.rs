//! Schedule as a command: one period of the operating point, or a campaign of many.

use super::{Job, budget};
use crate::error::Failure;
use crate::formats::model_file::QUANTIZE_FIRST;
use crate::network::early_exits::stored;
use crate::report::timeline;
use crate::results::{Campaign, FittedExit, Schedule};
use crate::scheduling::campaign::{Exits, Settings, plain, simulate};
use crate::scheduling::playback;
use std::io;

impl Job {
    /// One period of the run's operating point: `schedule.json` and a figure.
    ///
    /// # Errors
    ///
    /// No run, or one of another scenario than the one given; numbers that are not a plan.
    pub fn schedule(self) -> Result<Schedule, Failure> {
        let schedule = playback::play(&self.run()?.operating_point)?;
        // the plan is the run's: another scenario would need another
        let scenario = self.run_scenario()?;
        let job = Job { scenario, ..self.of_folder()? };
        job.output.write_result("schedule.json", &schedule)?;
        job.draw_period(&schedule.timeline)?;
        Ok(schedule)
    }

    /// The N_s stated, or that of the run's operating point.
    ///
    /// # Errors
    ///
    /// No run in the folder.
    pub fn sensing_slots_or_operating_point(&self, stated: Option<u32>) -> Result<u32, Failure> {
        stated.map_or_else(|| Ok(self.run()?.operating_point.sensing_slots), Ok)
    }

    /// Many periods: `campaign.json`, `trace.json` and a figure of the first, in the scenario of the folder's run if it has one.
    /// With a `threshold` sensing may end early. The period in s is returned too.
    ///
    /// # Errors
    ///
    /// Settings outside their ranges; models or early exits that are not there.
    pub fn campaign(
        mut self,
        settings: &Settings,
        threshold: Option<f64>,
    ) -> Result<(Campaign, f64), Failure> {
        if self.own_run()?.is_some() || settings.recognise_every > 0 {
            self = self.of_folder()?;
        }
        settings.check(&self.scenario, threshold)?;
        budget::campaign(&self, settings.periods)?;
        self.record("schedule")?;
        let stage = self.progress.stage("schedule", "periods");
        let models = if settings.recognise_every > 0 { self.models(QUANTIZE_FIRST)? } else { Vec::new() };
        let exits = match threshold {
            Some(threshold) if settings.recognise_every > 0 => Exits::Fitted(self.fitted_exits()?, threshold),
            _ => Exits::None,
        };
        let progress = |done, all| stage.at(done, all);
        let mut refused = None;
        let played = self.output.fill("trace.json", |file| {
            match simulate(&self.scenario, settings, self.seed, &models, &exits, file, &progress) {
                Ok((played, written)) => written.map(|()| played),
                Err(error) => Err(io::Error::other(refused.insert(error).to_string())),
            }
        });
        if let Some(error) = refused {
            return Err(error);
        }
        let played = played?;
        let found = played.campaign;
        stage.finish(&format!("{} decisions, {} violations", found.decisions, found.violations.len()));
        if settings.recognise_every == 0 {
            self.progress.note("schedule", &plain::speeds(&played.plan, found.decisions, played.took_s));
        }
        self.output.write_result("campaign.json", &found)?;
        self.draw_period(&found.timeline)?;
        Ok((found, self.scenario.period_s()))
    }

    /// The exits that `sdp3 early-exits` fitted to the models.
    fn fitted_exits(&self) -> Result<Vec<FittedExit>, Failure> {
        let known = stored::fit_of(&self.output)?;
        let slots: Vec<u32> = known.exits.iter().map(|exit| exit.sensing_slots).collect();
        let own = &self.scenario.frame.sensing_slots;
        match slots == *own {
            true => Ok(known.exits),
            false => {
                Err(format!("early-exits.json: exits = {slots:?} are not frame.sensing_slots = {own:?}")
                    .into())
            }
        }
    }

    /// The (first) period's slots as a picture.
    fn draw_period(&self, runs: &[(i32, u32)]) -> Result<(), Failure> {
        self.draw("timeline", &timeline::svg(runs, self.scenario.period_s()))
    }
}
