//! What the base station does not decide: channels, arrivals, who is there, which slots are lost.

use super::Settings;
use crate::numerics::random::Random;
use crate::optimizer::throughput::slot_bit;
use crate::results::CampaignUser;
use crate::scenario::Scenario;
use crate::simulator::channel::link::response;
use sdp3_core::scheduler::USERS;

/// Stream number of everything random here.
const STREAM: u64 = 203;

/// Different channels of a user that are drawn from.
const CHANNELS: u32 = 64;

/// Packets that make up a user's mean arrivals of a period.
const PACKETS: f64 = 20.0;

/// Users, their channels and queues.
///
/// A channel is one of the channel model's draws and is drawn again with probability 1 - exp(-T / coherence) in a period T: its
/// correlation falls exponentially and every draw follows the model.
#[derive(Debug, Clone)]
pub struct Environment {
    pub present: [bool; USERS],
    /// Bits one slot carries to each user now.
    pub slot_bit: [f64; USERS],
    /// Bits per slot of the channels that are drawn from, `[user][draw]`.
    channels: Vec<Vec<f64>>,
    random: Random,
    queue: [f64; USERS],
    offered: [f64; USERS],
    delivered: [f64; USERS],
    /// Mean arrivals of a period in bits at a load of 1.
    fair_bit: f64,
    full: bool,
}

/// What a period's end changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Changed {
    /// Channels, or who is there.
    pub rates: bool,
    /// The new N_s, if the target is another.
    pub sensing_slots: Option<u32>,
}

impl Environment {
    /// The users of case `optimizer.case` are there, links that are stated do not fade; further ones, placed at random, may come.
    pub fn new(scenario: &Scenario, settings: &Settings, seed: u64) -> Self {
        let mut random = Random::new(seed, STREAM, 0, 0);
        let (room, station) = (scenario.room.size_m, scenario.radar.position_m);
        let mut places = scenario.communication.cases[scenario.optimizer.case as usize - 1].clone();
        let there = places.len();
        while places.len() < USERS {
            let place = [room[0] * random.uniform(), room[1] * random.uniform(), station[2]];
            if (place[0] - station[0]).hypot(place[1] - station[1]) >= 0.5 {
                places.push(place);
            }
        }
        let bits = |place| {
            let draw = |draw| {
                let h = response(scenario, place, seed, draw);
                slot_bit(scenario, &h.iter().map(|z| z.norm_sqr()).collect::<Vec<_>>())
            };
            (0..CHANNELS).map(draw).collect::<Vec<f64>>()
        };
        let known = scenario.communication.slot_bit.as_ref();
        let known = known.map_or(&[][..], |cases| &cases[scenario.optimizer.case as usize - 1]);
        let stated = |k: usize| known.get(k).map(|&bit| vec![bit]);
        let channels: Vec<Vec<f64>> = places
            .into_iter()
            .enumerate()
            .map(|(k, place)| stated(k).unwrap_or_else(|| bits(place)))
            .collect();
        let present = std::array::from_fn(|k| k < there);
        let mut slot_bit = [0.0; USERS];
        slot_bit.iter_mut().zip(&channels).for_each(|(bit, all)| *bit = draw(all, &mut random));
        let others = f64::from(scenario.frame.period_slots - settings.sensing_slots);
        let fair_bit = others / slot_bit.iter().take(there).map(|bit| 1.0 / bit).sum::<f64>();
        Environment {
            present,
            slot_bit,
            channels,
            random,
            queue: [0.0; USERS],
            offered: [0.0; USERS],
            delivered: [0.0; USERS],
            fair_bit,
            full: settings.load.is_none(),
        }
    }

    /// Slots until one is lost, geometric.
    pub fn slots_until_loss(&mut self, probability: f64) -> u64 {
        if probability <= 0.0 {
            return u64::MAX;
        }
        (libm::log(1.0 - self.random.uniform()) / libm::log1p(-probability.min(1.0 - 1e-12))) as u64
    }

    /// Arrivals of a period: a Poisson number of packets for everybody there.
    pub fn arrive(&mut self, settings: &Settings) {
        let Some(load) = settings.load else { return };
        for k in 0..USERS {
            if self.present[k] {
                let bits = f64::from(self.random.poisson(PACKETS)) * load * self.fair_bit / PACKETS;
                self.queue[k] += bits;
                self.offered[k] += bits;
            }
        }
    }

    /// A slot for user `k`.
    pub fn deliver(&mut self, k: usize) {
        let bits = if self.full { self.slot_bit[k] } else { self.slot_bit[k].min(self.queue[k]) };
        self.queue[k] -= bits;
        self.delivered[k] += bits;
    }

    /// Bits delivered in the period that ends, taken over into the totals.
    pub fn drain(&mut self, users: &mut [CampaignUser]) -> [f64; USERS] {
        let delivered = std::mem::take(&mut self.delivered);
        for (k, r) in users.iter_mut().enumerate() {
            r.delivered_bit += delivered[k];
            r.offered_bit += if self.full { delivered[k] } else { self.offered[k] };
            self.offered[k] = 0.0;
        }
        delivered
    }

    /// Channels fade, users come and go, the target changes.
    pub fn change(&mut self, settings: &Settings, scenario: &Scenario) -> Changed {
        let period_s = scenario.frame.slot_s * f64::from(scenario.frame.period_slots);
        let fades = -libm::expm1(-period_s / settings.coherence_s);
        let mut rates = false;
        for k in 0..USERS {
            if self.random.uniform() < fades {
                self.slot_bit[k] = draw(&self.channels[k], &mut self.random);
                rates |= self.present[k];
            }
            if self.random.uniform() < settings.churn {
                let alone = self.present.iter().filter(|&&there| there).count() == 1;
                if !(self.present[k] && alone) {
                    self.present[k] = !self.present[k];
                    self.queue[k] = 0.0;
                    rates = true;
                }
            }
        }
        let targets = &scenario.frame.sensing_slots;
        let sensing_slots = (self.random.uniform() < settings.retarget)
            .then(|| targets[(self.random.uniform() * targets.len() as f64) as usize]);
        Changed { rates, sensing_slots }
    }
}

fn draw(all: &[f64], random: &mut Random) -> f64 {
    all[(random.uniform() * all.len() as f64) as usize]
}
