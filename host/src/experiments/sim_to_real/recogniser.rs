//! Networks for seconds of a Doppler sensor.

use super::seconds::Layout;
use crate::error::Failure;
use crate::experiments::{Request, RunContext};
use crate::network::evaluation::Networks;
use crate::network::float_network::{FloatNetwork, first_maximum};
use crate::network::parameters::{Images, Parameters};
use crate::network::training::{self, FINE_TUNING_RATE, train_all};
use crate::network::tuning::quantize_tuned;
use crate::simulator::randomised::Motion;
use sdp3_core::dims::ROWS;
use sdp3_core::dsn::head::arg_max;
use serde::{Deserialize, Serialize};

/// A network of one seed at one carrier.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Recogniser {
    /// Its float parameters.
    pub parameters: Parameters,
    /// Its int8 model file.
    pub model: Vec<u8>,
}

impl Recogniser {
    /// Trains on images, by the scenario's recipe; from a network on at a tenth of the learning rate.
    ///
    /// # Errors
    ///
    /// What the training or the quantisation says.
    pub fn learn(
        request: &Request,
        layout: &Layout,
        images: Images,
        start: Option<&Parameters>,
        seed: u64,
        context: RunContext,
    ) -> Result<Self, Failure> {
        let mut learning = request.scenario.learning.clone();
        if start.is_some() {
            learning.learning_rate *= FINE_TUNING_RATE;
        }
        let learning = &learning;
        let what = format!("three motions, {} seconds, seed {seed}", images.len());
        let stage = context.progress.stage("train", &what);
        let after_epoch = |_: usize, _: &dyn Fn() -> _, _: &[_]| {
            stage.step(u64::from(learning.epochs));
            Ok(())
        };
        let job = training::Job { seed: seed ^ 0x0073_7472, start: start.cloned(), ..Default::default() };
        let images = [images];
        let trained = train_all(&images, &[job], learning, Motion::ALL.len(), context.workers, &after_epoch)?;
        let parameters = trained.into_iter().next().ok_or("no network was trained")?.parameters;
        let names = Motion::ALL.map(|m| m.name().to_owned());
        let (quantized, _) =
            quantize_tuned(&parameters, layout.preprocessing(), &names, &images[0], learning)?;
        stage.finish(&what);
        Ok(Recogniser { parameters, model: quantized.to_bytes()? })
    }

    /// Logits of every image, in float.
    pub fn logits(&self, images: &Images) -> Vec<Vec<f32>> {
        let network = FloatNetwork::new(&self.parameters);
        (0..images.len()).map(|n| network.forward(images.image(n), ROWS, &mut |_, _| {})).collect()
    }

    /// Predictions in float.
    pub fn float(&self, images: &Images) -> Vec<u8> {
        self.logits(images).iter().map(|logits| first_maximum(logits)).collect()
    }

    /// Predictions of the core's int8 network.
    ///
    /// # Errors
    ///
    /// A model that the core refuses.
    pub fn int8(&self, layout: &Layout, images: &Images) -> Result<Vec<u8>, Failure> {
        let networks = Networks::parse(std::slice::from_ref(&self.model), &[layout.second() as u32])?;
        let found = networks.images(std::slice::from_ref(images));
        Ok(found.logits.iter().map(|of_networks| arg_max(&of_networks[0]) as u8).collect())
    }
}
