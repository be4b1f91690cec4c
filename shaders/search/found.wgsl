// The closest hit and the place of its sphere in spheres, where that does not follow from the id.

struct Found {
    hit: Hit,
    place: u32,
}

alias Searcher = Ray;
alias Best = Found;

// The place of the hit sphere in spheres.
var<private> place: u32;

fn load(n: u32) -> Record {
    return record_at(n);
}

fn test(ray: Ray, found: Found, r: Record, n: u32) -> Found {
    let hit = closer_hit_any_order(found.hit, ray, sphere_of(r), r.id);
    return Found(hit, select(found.place, n, hit.id != found.hit.id));
}

fn record_of(hit: Hit) -> Record {
    return record_at(place);
}
