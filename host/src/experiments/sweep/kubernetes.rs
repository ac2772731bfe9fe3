//! Kubernetes: an Indexed Job with a completion a shard, the plan in a ConfigMap, the results on a claim that many nodes write to.
//!
//! Kubernetes has no jobs that depend on others: the merge is a manifest of its own, to apply when the first is complete. A pod
//! that is killed is tried again three times; one that refuses its input (exit code 2) is not.

use super::plan::{PLAN, Sweep};
use super::shard::COMPLETIONS;
use crate::results::Submitted;
use crate::store::output::{Output, OutputError};

/// Writes `sweep.yaml` and `merge.yaml`, and the resolved plan, for an image with the entry point sdp3 and the name of a claim.
///
/// # Errors
///
/// A folder of another sweep, or one that cannot be written.
pub fn write(
    sweep: &Sweep,
    shards: u32,
    (image, claim): (&str, &str),
    output: &Output,
) -> Result<Submitted, OutputError> {
    sweep.open(output)?;
    let name = &sweep.plan.name;
    let jobs =
        [("sweep.yaml", indexed(sweep, shards, image, claim)), ("merge.yaml", merge(name, image, claim))];
    let mut files = Vec::new();
    for (file, text) in jobs {
        files.push(output.write(file, text.as_bytes())?.display().to_string());
    }
    Ok(Submitted { shards, files, array: None, merge: None })
}

/// A string of YAML: JSON's strings are.
fn text(value: &str) -> String {
    serde_json::Value::from(value).to_string()
}

fn indexed(sweep: &Sweep, shards: u32, image: &str, claim: &str) -> String {
    let (name, image, claim) = (&sweep.plan.name, text(image), text(claim));
    let plan: String = sweep.plan.to_toml().lines().map(|line| format!("    {line}\n")).collect();
    format!(
        "# kubectl apply -f sweep.yaml && kubectl wait --for=condition=complete --timeout=-1s job/{name}\n\
         apiVersion: v1
kind: ConfigMap
metadata:
  name: {name}-plan
data:
  {PLAN}: |
{plan}---
apiVersion: batch/v1
kind: Job
metadata:
  name: \"{name}\"
spec:
  completionMode: Indexed
  completions: {shards}
  parallelism: {shards}
  backoffLimitPerIndex: 3
  podFailurePolicy:
    rules:
      - action: FailIndex
        onExitCodes:
          containerName: sdp3
          operator: In
          values: [2]
  template:
    spec:
      restartPolicy: Never
      containers:
        - name: sdp3
          image: {image}
          args: [sweep, /plan/{PLAN}, --out, /results/{name}]
          env:
            - name: {COMPLETIONS}
              value: \"{shards}\"
          resources:
            requests:
              cpu: \"1\"
              memory: 1Gi
          volumeMounts:
            - name: plan
              mountPath: /plan
            - name: results
              mountPath: /results
      volumes:
        - name: plan
          configMap:
            name: {name}-plan
        - name: results
          persistentVolumeClaim:
            claimName: {claim}
"
    )
}

fn merge(name: &str, image: &str, claim: &str) -> String {
    let (image, claim) = (text(image), text(claim));
    format!(
        "# when the job {name} is complete: kubectl apply -f merge.yaml
apiVersion: batch/v1
kind: Job
metadata:
  name: {name}-merge
spec:
  backoffLimit: 1
  template:
    spec:
      restartPolicy: Never
      containers:
        - name: sdp3
          image: {image}
          args: [merge, /results/{name}]
          volumeMounts:
            - name: results
              mountPath: /results
      volumes:
        - name: results
          persistentVolumeClaim:
            claimName: {claim}
"
    )
}
