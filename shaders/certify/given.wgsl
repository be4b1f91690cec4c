// Bounds of t for a given ray and one sphere; docs/certificate.md, section 9, derives them. The unit is the tree's.

// A ray, seen from the middle of the spheres. Places are whole steps of a grid and a rest, since the difference of
// integers is exact and no compiler may reassociate it with floats.
struct CertifiedRay {
    steps: vec3<i32>,      // the origin, or a point ahead of it
    sure_limit: f32,       // a certain hit before it counts
    rest: vec3<f32>,
    limit: f32,            // no hit from here on counts
    direction: vec3<f32>,  // its largest component is in [1, 2)
    blur: f32,             // bound of the error of the places of ray and sphere, in each component
}

// The t at which a ray hits a sphere, if it does. `low` is MISS for a certain miss.
struct Bounds {
    low: f32,
    high: f32,
    sure: bool,
}

// Bounds of t for a ray and a sphere. `tilt` is the bound of the direction's error, relative to its length.
fn intersect(ray: CertifiedRay, tilt: f32, s: PlacedSphere) -> Bounds {
    let d = ray.direction;
    let p = vec3<f32>(s.steps - ray.steps) * GIVEN_STEP + (s.rest - ray.rest);
    let a = dot3(d, d);
    let b = dot3(p, d);
    let g = cross3(p, d);
    let p2 = dot3(p, p);
    let g2 = dot3(g, g);
    let r2 = s.radius * s.radius;
    let ar2 = a * r2;
    let far = sqrt(p2);
    let e = ((GIVEN_CROSS * UNIT + tilt) * far + GIVEN_BLURS * ray.blur) * sqrt(a) * INFLATE;
    let disc = ar2 - g2;
    let tilted = GIVEN_TILTS * tilt;
    let rounded = UNIT * (GIVEN_AR2 * ar2 + GIVEN_GG * g2) + tilted * (ar2 + g2);
    let error = ((2.0 * sqrt(g2) + e) * e + rounded) * INFLATE + a * VANISH;
    let power = p2 - r2;
    let power_error = (GIVEN_POWER * UNIT * (p2 + r2) + 2.0 * GIVEN_BLURS * ray.blur * (far + ray.blur)) * INFLATE;
    let outside = power > power_error;
    let inside = power < -power_error;
    if (!outside && !inside) {
        return Bounds(0.0, MISS, false);
    }
    if (outside && (b < -e || disc < -error)) {
        return Bounds(MISS, MISS, false);
    }
    let least = sqrt(positive(disc - error));
    let most = sqrt(positive(disc + error));
    let quotient = GIVEN_QUOTIENT * UNIT + tilted;
    let less = 1.0 - quotient;
    let more = 1.0 + quotient;
    if (inside && b >= 0.0) {
        return Bounds(positive(b - e + least) / a * less, (b + e + most) / a * more, true);
    }
    // The root nearer to zero is the quotient of the power by the other; inside it has the other sign.
    let along = select(-b, b, outside);
    let size = abs(power);
    let q = along - e + least;
    let q_most = along + e + most;
    let low = select(0.0, (size - power_error) / q_most * less, q_most > 0.0);
    let high = select(MISS, (size + power_error) / q * more, q > 0.0);
    return Bounds(low, high, q > 0.0 && (inside || (disc > error && b > e)));
}
