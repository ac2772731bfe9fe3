//! The backbone as an operation of burn's CPU backend: one node of the autodiff graph instead of hundreds.
//!
//! Its inputs are the images, which have no gradient, and all parameters in one tensor, which has.

use super::{Forward, Shape, Workspace, backward, forward};
use burn::backend::autodiff::checkpoint::base::Checkpointer;
use burn::backend::autodiff::checkpoint::strategy::CheckpointStrategy;
use burn::backend::autodiff::grads::Gradients;
use burn::backend::autodiff::ops::{Backward, Ops, OpsKind};
use burn::backend::tensor::FloatTensor;
use burn::backend::{Autodiff, Backend, Dispatch, ExtensionType, Flex, backend_extension};
use burn::tensor::{Tensor, TensorData};
use std::sync::Arc;

/// What the backbone gives.
#[derive(ExtensionType)]
pub struct Backbone<B: Backend> {
    /// Mean of every channel, `[batch, C]`.
    pub features: FloatTensor<B>,
    /// Statistics of the normalisations, in the order of [`Forward::statistics`]; without gradient.
    pub statistics: FloatTensor<B>,
}

/// Backends that have the backbone as an operation.
#[backend_extension(Flex, Autodiff)]
pub trait BackboneBackend: Backend {
    /// Backbone of `images` `[batch, 1, rows, frames]` under `parameters`, in the order of [`Shape::parameters`].
    fn backbone(
        images: FloatTensor<Self>,
        parameters: FloatTensor<Self>,
        shape: Shape,
        workspace: Workspace,
    ) -> Backbone<Self>;
}

type Values = FloatTensor<Flex>;

fn tensor<const D: usize>(values: Vec<f32>, shape: [usize; D]) -> Values {
    Values::from_data(TensorData::new(values, shape))
}

/// The pass and its inputs, values contiguous.
fn run(images: &Values, parameters: &Values, shape: Shape, workspace: &Workspace) -> (Forward, Saved) {
    let saved = Saved { images: images.to_contiguous(), parameters: parameters.to_contiguous() };
    let pass = forward(shape, values(&saved.images), values(&saved.parameters), workspace);
    (pass, saved)
}

fn values(tensor: &Values) -> &[f32] {
    let (start, length) = (tensor.layout().start_offset(), tensor.layout().num_elements());
    &tensor.storage::<f32>()[start..start + length]
}

fn outputs(pass: &Forward, shape: &Shape) -> (Values, Values) {
    let features = tensor(pass.features.clone(), [shape.batch, shape.channels]);
    (features, tensor(pass.statistics(), [shape.statistics()]))
}

impl BackboneBackend for Flex {
    fn backbone(images: Values, parameters: Values, shape: Shape, workspace: Workspace) -> Backbone<Flex> {
        let (features, statistics) = outputs(&run(&images, &parameters, shape, &workspace).0, &shape);
        Backbone { features, statistics }
    }
}

#[derive(Debug)]
struct Saved {
    images: Values,
    parameters: Values,
}

#[derive(Debug)]
struct BackboneBackward;

impl Backward<Flex, 1> for BackboneBackward {
    type State = Arc<(Forward, Saved)>;

    fn backward(self, ops: Ops<Self::State, 1>, gradients: &mut Gradients, _: &mut Checkpointer) {
        let features = gradients.consume::<Flex>(&ops.node).to_contiguous();
        let (pass, saved) = &*ops.state;
        let [parameters] = ops.parents;
        if let Some(node) = parameters {
            let found = backward(pass, values(&saved.images), values(&saved.parameters), values(&features));
            let length = found.len();
            gradients.register::<Flex>(node.id, tensor(found, [length]));
        }
    }
}

impl<C: CheckpointStrategy> BackboneBackend for Autodiff<Flex, C> {
    fn backbone(
        images: FloatTensor<Self>,
        parameters: FloatTensor<Self>,
        shape: Shape,
        workspace: Workspace,
    ) -> Backbone<Self> {
        let (pass, saved) = run(images.primitive(), parameters.primitive(), shape, &workspace);
        let (features, statistics) = outputs(&pass, &shape);
        let node = BackboneBackward.prepare::<C>([parameters.node()]).compute_bound().stateful();
        let features = match node {
            OpsKind::Tracked(prepared) => prepared.finish(Arc::new((pass, saved)), features),
            OpsKind::UnTracked(prepared) => prepared.finish(features),
        };
        Backbone { features, statistics: FloatTensor::<Self>::new(statistics) }
    }
}

/// Features `[batch, C]` and statistics of `images` `[batch, 1, rows, frames]`, on the CPU.
///
/// # Panics
///
/// If the images or the parameters are not of the shape's size, or lie on another backend than `flex`.
pub fn backbone(
    images: Tensor<4>,
    parameters: Tensor<1>,
    shape: Shape,
    workspace: &Workspace,
) -> (Tensor<2>, Tensor<1>) {
    assert_eq!(images.dims(), [shape.batch, 1, shape.rows, shape.frames]);
    assert_eq!(parameters.dims(), [shape.parameters()]);
    let (images, parameters) = (images.into_dispatch(), parameters.into_dispatch());
    let found = <Dispatch as BackboneBackend>::backbone(images, parameters, shape, workspace.clone());
    (Tensor::from_dispatch(found.features), Tensor::from_dispatch(found.statistics))
}
