//! Who moves in front of the radar, and how.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// A person's motion: the five classes of the paper in the order of their labels, then those only simulated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Class {
    /// A child or an adult standing.
    Standing,
    /// A child walking.
    ChildWalking,
    /// A child pacing (a slow walk).
    ChildPacing,
    /// An adult walking.
    AdultWalking,
    /// An adult pacing.
    AdultPacing,
    /// A child stepping on the spot.
    ChildStepping,
    /// An adult stepping on the spot.
    AdultStepping,
    /// A child running.
    ChildRunning,
    /// An adult running.
    AdultRunning,
    /// An adult sitting down on a chair.
    SittingDown,
    /// An adult standing up from a chair.
    StandingUp,
    /// An adult falling to the floor: forward, backward or sideways.
    Falling,
    /// An adult bending down and straightening up, again and again.
    Bending,
    /// An adult waving with one arm.
    Waving,
    /// An adult jumping on the spot, again and again.
    Jumping,
}

impl Class {
    /// The paper's classes; the index is the label.
    pub const ALL: [Class; 5] =
        [Class::Standing, Class::ChildWalking, Class::ChildPacing, Class::AdultWalking, Class::AdultPacing];

    /// Every motion there is.
    pub const EVERY: [Class; 15] = [
        Class::Standing,
        Class::ChildWalking,
        Class::ChildPacing,
        Class::AdultWalking,
        Class::AdultPacing,
        Class::ChildStepping,
        Class::AdultStepping,
        Class::ChildRunning,
        Class::AdultRunning,
        Class::SittingDown,
        Class::StandingUp,
        Class::Falling,
        Class::Bending,
        Class::Waving,
        Class::Jumping,
    ];

    /// Whether a child moves; standing people may be either.
    pub fn child(self) -> Option<bool> {
        match self {
            Class::Standing => None,
            Class::ChildWalking | Class::ChildPacing | Class::ChildStepping | Class::ChildRunning => {
                Some(true)
            }
            Class::AdultWalking
            | Class::AdultPacing
            | Class::AdultStepping
            | Class::AdultRunning
            | Class::SittingDown
            | Class::StandingUp
            | Class::Falling
            | Class::Bending
            | Class::Waving
            | Class::Jumping => Some(false),
        }
    }

    /// Whether the person stays where it is.
    pub fn on_the_spot(self) -> bool {
        match self {
            Class::ChildWalking
            | Class::ChildPacing
            | Class::AdultWalking
            | Class::AdultPacing
            | Class::ChildRunning
            | Class::AdultRunning => false,
            Class::Standing
            | Class::ChildStepping
            | Class::AdultStepping
            | Class::SittingDown
            | Class::StandingUp
            | Class::Falling
            | Class::Bending
            | Class::Waving
            | Class::Jumping => true,
        }
    }

    /// The name used in files and pages.
    pub fn name(self) -> &'static str {
        match self {
            Class::ChildStepping => "child-stepping",
            Class::AdultStepping => "adult-stepping",
            Class::ChildRunning => "child-running",
            Class::AdultRunning => "adult-running",
            Class::Standing => "standing",
            Class::ChildWalking => "child-walking",
            Class::ChildPacing => "child-pacing",
            Class::AdultWalking => "adult-walking",
            Class::AdultPacing => "adult-pacing",
            Class::SittingDown => "sitting-down",
            Class::StandingUp => "standing-up",
            Class::Falling => "falling",
            Class::Bending => "bending",
            Class::Waving => "waving",
            Class::Jumping => "jumping",
        }
    }
}

/// The person sensed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Target {
    /// Ground position at the start in m.
    pub start_m: [f64; 2],
    /// Way points on the ground in m; with two or more the walk leads through them and the heading is theirs.
    pub waypoints_m: Vec<[f64; 2]>,
    /// Whether who comes near a wall turns; else the walk goes straight on.
    pub turns: bool,
    /// Headings are uniform within plus or minus this many degrees around the direction to the radar.
    pub heading_spread_deg: f64,
    /// Standard deviation of the walking speed relative to its mean.
    pub speed_jitter: f64,
    /// Range of an adult's height in m.
    pub adult_height_m: [f64; 2],
    /// Range of a child's height in m.
    pub child_height_m: [f64; 2],
    /// Joints of the first person from a motion capture (CSV or BVH) instead of the gait.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub capture: Option<PathBuf>,
    /// Further people in the room.
    pub others: Vec<Other>,
}

impl Target {
    /// Ground position at the start in m: the first way point, if there is one.
    pub fn begin_m(&self) -> [f64; 2] {
        self.waypoints_m.first().copied().unwrap_or(self.start_m)
    }
}

/// A further person.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Other {
    /// Its motion.
    pub class: Class,
    /// Ground position at the start in m.
    pub start_m: [f64; 2],
    /// Heading in degrees, counter-clockwise from the x axis; absent: any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub heading_deg: Option<f64>,
}
