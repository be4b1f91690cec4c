//! Chooses accuracy and method, with reasons.

use crate::frame::Aov;
use crate::intersect::Method;
use crate::intersect::predict::Prediction;
use crate::scene::Scene;
use crate::settings::{Accuracy, Settings};
use halfline_ground::error::{Error, Result};
use halfline_ground::quote::number;
use halfline_ground::quote::setting::{ACCURACY, METHOD};

/// A choice and its reason.
pub(super) struct Choice {
    pub(super) accuracy: Accuracy,
    /// `None` for the certified kernel or the judge.
    pub(super) method: Option<Method>,
    pub(super) reason: String,
    pub(super) predicted: Option<Prediction>,
}

/// The buffers that hold answers rather than looks. Requesting one implies a certificate, unless a tolerance is given.
const ANSWERS: [Aov; 8] =
    [Aov::Distance, Aov::Depth, Aov::Normal, Aov::Position, Aov::Id, Aov::Mask, Aov::Certainty, Aov::Bound];

/// The buffers that no prediction covers: two are about proofs, and normals are not predicted.
const PROVEN: [Aov; 3] = [Aov::Certainty, Aov::Bound, Aov::Normal];

/// Cost of a certified frame relative to `stable` with all spheres in view (docs/certificate.md, section 6).
const CERTIFIED: f64 = 1.1;

/// Above this number of spheres no method is chosen: it tests all of them, and certified answers take no longer.
pub(in crate::render) const MAX_FOR_METHOD: usize = 8;

pub(super) fn choose(scene: &Scene, settings: &Settings, admits: &mut dyn FnMut(Method) -> bool) -> Result<Choice> {
    let choice =
        |accuracy, method: Option<Method>, reason: String| Choice { accuracy, method, reason, predicted: None };
    if scene.spheres.cuts.is_some() {
        return match (settings.accuracy, settings.method) {
            (Accuracy::Exact, None) => Ok(choice(Accuracy::Exact, None, "exact arithmetic is requested".into())),
            (Accuracy::Auto | Accuracy::Certified, None) => {
                Ok(choice(Accuracy::Certified, None, "spheres that planes cut are certified".into()))
            }
            _ => Err(cut_by_method()),
        };
    }
    let is_parallel = scene.camera.lens.is_orthographic();
    if let (true, Some(method)) = (is_parallel, settings.method) {
        let problem = format!("method {} does not support orthographic cameras", method.name());
        return Err(Error::settings(problem, format!("remove {METHOD}, or give the camera a vfov")));
    }
    if is_parallel && settings.accuracy == Accuracy::Auto {
        let reason = match settings.tolerance {
            Some(tolerance) => {
                format!("parallel rays are certified, distance within {}", number(tolerance.relative(), 2))
            }
            None => "parallel rays are certified: the uncertified methods support perspective cameras only".into(),
        };
        return Ok(choice(Accuracy::Certified, None, reason));
    }
    let few = scene.spheres.len() <= MAX_FOR_METHOD && !is_parallel;
    let named = |some: &[Aov]| {
        let requested: Vec<_> = some.iter().filter(|aov| settings.aovs.contains(aov)).map(|aov| aov.name()).collect();
        requested.join(", ")
    };
    Ok(match (settings.accuracy, settings.method, settings.tolerance) {
        (Accuracy::Auto, Some(method), _) => {
            choice(Accuracy::Fast, Some(method), format!("method {} is requested, and is uncertified", method.name()))
        }
        (Accuracy::Auto, None, Some(_)) if settings.asks(&PROVEN) => {
            let reason = format!("a tolerance is given, but errors of {} are not predicted", named(&PROVEN));
            choice(Accuracy::Certified, None, reason)
        }
        (Accuracy::Auto, None, Some(tolerance)) if !few => {
            let reason = format!(
                "certified, distance within {}: with {} spheres no method is cheaper",
                number(tolerance.relative(), 2),
                scene.spheres.len()
            );
            choice(Accuracy::Certified, None, reason)
        }
        (Accuracy::Auto, None, Some(tolerance)) => cheapest(scene, tolerance.relative(), admits)?,
        (Accuracy::Auto, None, None) if settings.asks(&ANSWERS) => {
            choice(Accuracy::Certified, None, format!("buffers that hold answers are requested: {}", named(&ANSWERS)))
        }
        (Accuracy::Auto, None, None) if settings.coverage => {
            choice(Accuracy::Certified, None, "the spheres of samples are counted, which are answers".into())
        }
        (Accuracy::Auto, None, None) if !few => {
            let reason = format!("with {} spheres no method is cheaper than certified answers", scene.spheres.len());
            choice(Accuracy::Certified, None, reason)
        }
        (Accuracy::Auto, None, None) => {
            let predicted = Prediction::of(scene, Method::Stable)?;
            match predicted.filter(Prediction::is_visible) {
                Some(Prediction { outline, distance, .. }) => {
                    let [outline, distance] = [outline, distance].map(|x| number(x, 2));
                    let reason = format!(
                        "certified: method stable could be off by {outline} radii and {distance} of a distance, which can be seen"
                    );
                    choice(Accuracy::Certified, None, reason)
                }
                None => {
                    let reason = "no buffer that holds answers and no tolerance is requested".into();
                    Choice { predicted, ..choice(Accuracy::Fast, Some(Method::Stable), reason) }
                }
            }
        }
        (Accuracy::Fast, None, _) if !few => {
            let reason =
                "accuracy fast is requested: the certified kernel, whose unproved pixels take their nearest candidate";
            choice(Accuracy::Fast, None, reason.into())
        }
        (stated, method, _) => {
            let method = method.or((stated == Accuracy::Fast).then_some(Method::Stable));
            choice(stated, method, format!("accuracy {} is requested", stated.name()))
        }
    })
}

/// The error of an answer without a proof where planes cut spheres.
pub(in crate::render) fn cut_by_method() -> Error {
    let problem = "planes cut some spheres, and an answer without a proof takes them for whole";
    Error::settings(problem, format!("remove {METHOD} or {ACCURACY}"))
}

/// The cheapest method whose predicted errors stay within `tolerance`; certified if there is none, or none cheaper.
fn cheapest(scene: &Scene, tolerance: f64, admits: &mut dyn FnMut(Method) -> bool) -> Result<Choice> {
    let mut methods: Vec<_> = Method::ALL.iter().copied().filter(|method| method.cost() < CERTIFIED).collect();
    methods.retain(|method| admits(*method));
    methods.sort_by(|a, b| a.cost().total_cmp(&b.cost()));
    let each = methods.iter().map(|method| Prediction::of(scene, *method));
    let Some(predicted) = each.collect::<Result<Option<Vec<_>>>>()? else {
        let method = methods.first().copied().unwrap_or(Method::Stable);
        let reason = "there are no spheres, so there is no error".into();
        return Ok(Choice { accuracy: Accuracy::Fast, method: Some(method), reason, predicted: None });
    };
    let all: Vec<_> = methods.into_iter().zip(predicted).collect();
    let within = |p: &Prediction| {
        let [outline, distance] = [p.outline, p.distance].map(|x| number(x, 2));
        format!("predicted outline within {outline} radii and distance within {distance}")
    };
    let allowed = number(tolerance, 2);
    if let Some(n) = all.iter().position(|(_, p)| p.worst() <= tolerance) {
        let (method, p) = all[n];
        let mut reason = format!("method {}: {}, tolerance {allowed}", method.name(), within(&p));
        if let Some((cheaper, p)) = all[..n].first() {
            reason += &format!("; {} could be off by {}", cheaper.name(), number(p.worst(), 2));
        }
        return Ok(Choice { accuracy: Accuracy::Fast, method: Some(method), reason, predicted: Some(p) });
    }
    let best = all.iter().min_by(|a, b| a.1.worst().total_cmp(&b.1.worst()));
    let reason = best.map_or("no method can run here".into(), |(method, p)| {
        format!(
            "certified: no cheaper method stays within the tolerance {allowed}; {} comes closest: {}, worst at sphere {}, \
             {} radii away",
            method.name(),
            within(p),
            p.sphere,
            number(p.radii, 2)
        )
    });
    Ok(Choice { accuracy: Accuracy::Certified, method: None, reason, predicted: None })
}
