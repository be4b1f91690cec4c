//! Which accuracy and which method, and why.

use crate::error::{Error, Result};
use crate::frame::Aov;
use crate::intersect::Method;
use crate::predict::Prediction;
use crate::scene::Scene;
use crate::settings::{Accuracy, Settings};

/// What is chosen, and the words for it.
pub(super) struct Choice {
    pub(super) accuracy: Accuracy,
    pub(super) method: Method,
    pub(super) reason: String,
    pub(super) predicted: Option<Prediction>,
}

/// The buffers that are answers, not looks: asking for one asks for a certificate, unless a tolerance says what will do.
const ANSWERS: [Aov; 8] =
    [Aov::Distance, Aov::Depth, Aov::Normal, Aov::Position, Aov::Id, Aov::Mask, Aov::Certainty, Aov::Bound];

/// The buffers that no prediction can answer for: two tell of proofs, and nothing is predicted of normals.
const PROVEN: [Aov; 3] = [Aov::Certainty, Aov::Bound, Aov::Normal];

/// What a certified frame costs beside `stable` with all spheres in view (docs/certificate.md, section 6).
const CERTIFIED: f64 = 1.1;

/// Spheres beyond which certified answers are preferred: by tiles, a form costs two thirds of them (lavapipe, 1e3 spheres)
/// to twice as much (lavapipe and the CPU path, 1e6): docs/performance.md.
const FEW: usize = 32;

pub(super) fn choose(scene: &Scene, settings: &Settings, admits: &mut dyn FnMut(Method) -> bool) -> Result<Choice> {
    let choice = |accuracy, method: Option<Method>, reason: String| Choice {
        accuracy,
        method: method.unwrap_or(Method::Stable),
        reason,
        predicted: None,
    };
    if scene.camera.lens.is_orthographic() && settings.accuracy != Accuracy::Exact {
        return parallel(settings).map(|reason| choice(Accuracy::Certified, None, reason));
    }
    let named = |some: &[Aov]| {
        let asked: Vec<_> = some.iter().filter(|aov| settings.aovs.contains(aov)).map(|aov| aov.name()).collect();
        asked.join(", ")
    };
    Ok(match (settings.accuracy, settings.method, settings.tolerance) {
        (Accuracy::Auto, Some(method), _) => {
            choice(Accuracy::Fast, Some(method), format!("method {} was asked for, and runs alone", method.name()))
        }
        (Accuracy::Auto, None, Some(_)) if settings.asks(&PROVEN) => {
            let reason = format!("a tolerance is given, and no prediction vouches for {}", named(&PROVEN));
            choice(Accuracy::Certified, None, reason)
        }
        (Accuracy::Auto, None, Some(tolerance)) if scene.spheres.len() > FEW => {
            let reason = format!(
                "certified, distance within {:.1e}: with {} spheres no form is cheaper by much",
                tolerance.relative(),
                scene.spheres.len()
            );
            choice(Accuracy::Certified, None, reason)
        }
        (Accuracy::Auto, None, Some(tolerance)) => cheapest(scene, tolerance.relative(), admits)?,
        (Accuracy::Auto, None, None) if settings.asks(&ANSWERS) => {
            choice(Accuracy::Certified, None, format!("buffers of answers are asked for: {}", named(&ANSWERS)))
        }
        (Accuracy::Auto, None, None) if scene.spheres.len() > FEW => {
            let reason =
                format!("with {} spheres no form is cheaper by much than certified answers", scene.spheres.len());
            choice(Accuracy::Certified, None, reason)
        }
        (Accuracy::Auto, None, None) => {
            choice(Accuracy::Fast, None, "no buffer of answers and no tolerance is asked for".into())
        }
        (stated, method, _) => choice(stated, method, format!("accuracy {} was asked for", stated.name())),
    })
}

/// Why answers by parallel rays are certified: no form was written for them, and a certified frame costs less than a form
/// that asks every sphere.
fn parallel(settings: &Settings) -> Result<String> {
    if let Some(method) = settings.method {
        let problem = format!("method {} has no parallel rays: orthographic frames are certified", method.name());
        return Err(Error::settings(problem, "leave out --method, or give the camera a vfov"));
    }
    Ok(match (settings.accuracy, settings.tolerance) {
        (Accuracy::Certified, _) => "accuracy certified was asked for".into(),
        (Accuracy::Fast, _) => {
            "accuracy fast was asked for, and parallel rays are certified in f32: no form is faster".into()
        }
        (_, Some(tolerance)) => {
            format!("parallel rays are certified, distance within {:.1e}", tolerance.relative())
        }
        _ => "parallel rays are certified: the forms that run alone have one eye".into(),
    })
}

/// The cheapest method whose predicted errors `tolerance` allows; certified if none is, or none that is cheaper.
fn cheapest(scene: &Scene, tolerance: f64, admits: &mut dyn FnMut(Method) -> bool) -> Result<Choice> {
    let mut methods: Vec<_> = Method::ALL.iter().copied().filter(|method| method.cost() < CERTIFIED).collect();
    methods.retain(|method| admits(*method));
    methods.sort_by(|a, b| a.cost().total_cmp(&b.cost()));
    let Some(predicted) = Prediction::each(scene, &methods)? else {
        let method = methods.first().copied().unwrap_or(Method::Stable);
        let reason = "there are no spheres to be wrong about".into();
        return Ok(Choice { accuracy: Accuracy::Fast, method, reason, predicted: None });
    };
    let all: Vec<_> = methods.into_iter().zip(predicted).collect();
    let within = |p: &Prediction| {
        format!("predicted outline within {:.1e} radii and distance within {:.1e}", p.outline, p.distance)
    };
    if let Some(n) = all.iter().position(|(_, p)| p.worst() <= tolerance) {
        let (method, p) = all[n];
        let mut reason = format!("method {}: {}, tolerance {tolerance:.1e}", method.name(), within(&p));
        if let Some((cheaper, p)) = all[..n].first() {
            reason += &format!("; {} would be off by {:.1e}", cheaper.name(), p.worst());
        }
        return Ok(Choice { accuracy: Accuracy::Fast, method, reason, predicted: Some(p) });
    }
    let best = all.iter().min_by(|a, b| a.1.worst().total_cmp(&b.1.worst()));
    let reason = best.map_or("no method runs here".into(), |(method, p)| {
        format!(
            "certified: no cheaper method keeps the tolerance {tolerance:.1e}; {} comes closest: {}, worst at sphere {}, \
             {:.1e} radii away",
            method.name(),
            within(p),
            p.sphere,
            p.radii
        )
    });
    Ok(Choice { accuracy: Accuracy::Certified, method: Method::Stable, reason, predicted: None })
}
