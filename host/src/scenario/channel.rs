//! The channel model and its settings.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The recursion of the room's channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ArMode {
    /// As printed: v_1 = Upsilon_1, v_j = rho v_{j-1} + (1 - rho) Upsilon_j.
    Paper,
    /// v_j = rho v_{j-1} + sqrt(1 - rho^2) Upsilon_j: the power does not depend on rho.
    VariancePreserving,
    /// Rays given by geometry keep their phase; only the diffuse rays are redrawn.
    Consistent,
    /// A constant mean from geometry, v_j = m + w_j, and a stationary fluctuation w_j = rho w_{j-1} + sqrt(1 - rho^2) Upsilon_j. Its power is
    /// the mean's over the K factor.
    Rician,
}

/// Channel models, by the names of the paper's Table I.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Model {
    /// The data-assisted hybrid channel.
    Dahc,
    /// Primitives and a room that never changes.
    Primitive,
    /// Image method with Fresnel materials.
    RayTracing,
    /// Saleh-Valenzuela.
    Statistical,
    /// IEEE 802.11ay quasi-deterministic conference room.
    #[serde(rename = "80211ay")]
    Ieee80211ay,
    /// IEEE 802.11 TGn/TGac/TGax taps.
    #[serde(rename = "80211ax")]
    Ieee80211ax,
    /// 3GPP TR 38.901 indoor office.
    #[serde(rename = "38901")]
    Tr38901,
    /// QuaDRiGa's drifting clusters.
    Quadriga,
    /// METIS' map-based hybrid.
    Metis,
}

impl Model {
    /// All models.
    pub const ALL: [Model; 9] = [
        Model::Dahc,
        Model::Primitive,
        Model::RayTracing,
        Model::Statistical,
        Model::Ieee80211ay,
        Model::Ieee80211ax,
        Model::Tr38901,
        Model::Quadriga,
        Model::Metis,
    ];

    /// The name used on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Model::Dahc => "dahc",
            Model::Primitive => "primitive",
            Model::RayTracing => "ray-tracing",
            Model::Statistical => "statistical",
            Model::Ieee80211ay => "80211ay",
            Model::Ieee80211ax => "80211ax",
            Model::Tr38901 => "38901",
            Model::Quadriga => "quadriga",
            Model::Metis => "metis",
        }
    }
}

/// The TGn model that suits the room.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum Tgn {
    /// One tap: a flat channel.
    A,
    /// Residential, rms delay spread 15 ns.
    B,
    /// Small office, 30 ns.
    C,
    /// Typical office, 50 ns.
    D,
    /// Large office, 100 ns.
    E,
    /// Large open space, 150 ns.
    F,
}

/// When the room's recursion advances.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Advance {
    /// Once per sensing slot, as the authors' recordings were made.
    SensingSlot,
    /// Once per slot, also in those between two sensing slots.
    Slot,
}

/// Room channel statistics.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Clusters {
    /// IEEE 802.11ay conference room: image-method clusters with diffuse rays.
    #[serde(rename = "80211ay")]
    Ieee80211ay,
    /// IEEE 802.11ax / TGn taps.
    #[serde(rename = "80211ax")]
    Ieee80211ax,
    /// `80211ax` up to 6 GHz, `80211ay` from 57 GHz on; between them both, the share of `80211ay` in the power growing with the logarithm
    /// of the carrier.
    ByCarrier,
}

impl Clusters {
    /// Share of 802.11ay's clusters in the power at a carrier.
    pub fn share_80211ay(self, carrier_hz: f64) -> f64 {
        match self {
            Clusters::Ieee80211ay => 1.0,
            Clusters::Ieee80211ax => 0.0,
            Clusters::ByCarrier => {
                let place = libm::log(carrier_hz / 6e9) / libm::log(57.0 / 6.0);
                place.clamp(0.0, 1.0)
            }
        }
    }
}

/// Environments of IEEE 802.11ad/ay: the rays around a cluster's central one. Reflection losses are the conference room's in all.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Environment {
    /// Conference room.
    ConferenceRoom,
    /// Living room.
    LivingRoom,
    /// Office with cubicles.
    Cubicle,
    /// Hotel lobby.
    HotelLobby,
    /// Open area outdoors.
    OpenArea,
}

impl Environment {
    /// All environments.
    pub const ALL: [Environment; 5] = [
        Environment::ConferenceRoom,
        Environment::LivingRoom,
        Environment::Cubicle,
        Environment::HotelLobby,
        Environment::OpenArea,
    ];
}

/// Polarisation of the antennas.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Polarisation {
    /// Both vertical.
    Vertical,
    /// Both horizontal.
    Horizontal,
    /// A vertical transmitter and a horizontal receiver.
    Crossed,
}

/// How the taps of the statistical model change in time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Doppler {
    /// No law: a fresh draw wherever an antenna or a person has moved.
    Redrawn,
    /// TGn's bell spectrum 1 / (1 + 9 (f / f_d)^2), f_d that of 1.2 km/h: autocorrelation exp(-2 pi f_d t / 3).
    Bell,
    /// Clarke's spectrum at the same f_d: autocorrelation J0(2 pi f_d t).
    Clarke,
}

/// What the models that trace rays know of the room.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Interior {
    /// Six half spaces with the permittivities of the NIST Q-D software at 60 GHz.
    Bare,
    /// Slabs of the room's materials (ITU-R P.2040-3), and what stands in it.
    Furnished,
}

/// The channel model and its settings.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Channel {
    /// Which model.
    pub model: Model,
    /// AR(1) coefficient rho of the room channel; absent: taken from the calibration table.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rho: Option<f64>,
    /// The recursion.
    pub mode: ArMode,
    /// Power of the room's mean over that of its fluctuation in dB, as received (`mode = "rician"`).
    pub k_factor_db: f64,
    /// Power of the room's echoes over what its geometry and materials give in dB (`mode = "rician"`): more or less clutter.
    pub clutter_gain_db: f64,
    /// Where the room's responses come from.
    pub clusters: Clusters,
    /// When the recursion advances.
    pub advance: Advance,
    /// Whether the room's response starts with the power it settles at instead of Upsilon's.
    pub stationary_start: bool,
    /// Taps of `80211ax` and of the hybrid channel with those statistics.
    pub tgn: Tgn,
    /// Whether people and furniture may block reflections (`80211ay` and the hybrid channel with those statistics).
    pub blockage: bool,
    /// Whether people stand in the way of the room's reflections and of each other's echoes (the hybrid channel with `mode = "rician"`,
    /// `ray-tracing`, `metis`, `38901`).
    pub shadowing: bool,
    /// Whether a torso hides the limbs behind it (the hybrid channel, `ray-tracing`).
    pub occlusion: bool,
    /// Rays within a cluster (`80211ay` and the hybrid channel with those statistics).
    pub environment: Environment,
    /// Polarisation of transmitter and receiver (`80211ay`, `38901`).
    pub polarisation: Polarisation,
    /// How taps change in time (`statistical`).
    pub doppler: Doppler,
    /// What `ray-tracing` and `metis` know of the room.
    pub interior: Interior,
    /// Scattering coefficient S of surfaces, 0 to 1: the share S^2 of what a surface reflects is diffuse (`ray-tracing`, `metis`).
    pub scattering: f64,
    /// Whether waves bend around people and furniture (`ray-tracing`): Kirchhoff's integral over a screen; otherwise a screen hides what is
    /// behind it.
    pub diffraction: bool,
    /// Whether echoes of a person have two reflections at surfaces besides those with one (`ray-tracing`; it takes five times as long).
    pub double_bounce: bool,
    /// Whether links may be in line of sight: in `38901` with the probability of an open office, in `quadriga` all are.
    pub line_of_sight: bool,
    /// Whether a second person walks in the room (the paper's scenario 2).
    pub interferer: bool,
}
