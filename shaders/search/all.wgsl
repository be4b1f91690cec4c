// The closest hit among all spheres, in the order of their ids.
alias Searcher = Ray;
alias Best = Hit;

fn nearest(ray: Ray, group: vec3<u32>) -> Hit {
    var hit = no_hit();
    for (var first = 0u; first < view.spheres; first += CHUNK) {
        hit = test_chunk(ray, hit, first, min(CHUNK, view.spheres - first));
    }
    return hit;
}

// Past the end it repeats the last sphere, which is not closer than itself.
fn load(n: u32) -> Record {
    return record_at(min(n, view.spheres - 1u));
}

// n is the sphere's id.
fn test(ray: Ray, hit: Hit, r: Record, n: u32) -> Hit {
    return closer_hit(hit, ray, sphere_of(r), n);
}

fn record_of(hit: Hit) -> Record {
    return record_at(hit.id);
}
