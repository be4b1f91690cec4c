//! The pixels of a frame in which things are visible.

use std::collections::BTreeMap;

/// Spheres of a scene, with the text that names them.
pub type Thing = (String, Vec<u32>);

/// Labels of pixels: background, a sphere of no thing; then labels of the spheres that have the same things.
const BACKGROUND: u32 = 0;
const UNNAMED: u32 = 1;
const NAMED: u32 = 2;

/// The most places of a thing where its text may begin.
const MOST_PLACES: usize = 48;

/// Distances in the depth of pixels, in thirds of a pixel: to a neighbour, and to one at a corner (the 3-4 metric of G. Borgefors,
/// Distance transformations in digital images, Computer Vision, Graphics, and Image Processing 34, 1986).
const STEP: u32 = 3;
const CORNER: u32 = 4;

/// The pixels of a frame by what they show.
pub(super) struct VisibleThings {
    size: [usize; 2],
    /// The labels of the pixels: of the first spheres, then of the opaque ones behind translucent ones.
    images: Vec<Vec<u32>>,
    /// The numbers of the things of each label from [`NAMED`] on.
    named: Vec<Vec<u16>>,
    /// Each thing, if some pixel shows it.
    things: Vec<Option<VisibleThing>>,
}

/// A thing that some pixel shows.
pub(super) struct VisibleThing {
    number: u16,
    /// The image that shows it.
    image: usize,
    /// Pixels that show it, columns and rows: that farthest from everything else, that nearest to the middle of all, and others.
    pub(super) places: Vec<[usize; 2]>,
}

impl VisibleThings {
    /// The things in images of ids.
    pub(super) fn new(size: [usize; 2], things: &[Thing], ids: &[Vec<i32>]) -> Self {
        let mut of_sphere: BTreeMap<u32, Vec<u16>> = BTreeMap::new();
        for (number, (_, ids)) in (0..).zip(things) {
            ids.iter().for_each(|id| of_sphere.entry(*id).or_default().push(number));
        }
        let (mut named, mut known) = (Vec::new(), BTreeMap::new());
        let labels: BTreeMap<u32, u32> = of_sphere
            .into_iter()
            .map(|(id, list)| {
                let label = known.entry(list).or_insert_with_key(|list: &Vec<u16>| {
                    named.push(list.clone());
                    NAMED + named.len() as u32 - 1
                });
                (id, *label)
            })
            .collect();
        let label = |id: &i32| u32::try_from(*id).map_or(BACKGROUND, |id| labels.get(&id).copied().unwrap_or(UNNAMED));
        let images = ids.iter().map(|ids| ids.iter().map(label).collect()).collect();
        let mut visible = Self { size, images, named, things: Vec::new() };
        visible.things.resize_with(things.len(), || None);
        (0..visible.images.len()).for_each(|image| visible.find(image));
        visible
    }

    /// Finds the things that an image shows and those before it do not.
    fn find(&mut self, image: usize) {
        #[derive(Clone, Default)]
        struct Found {
            count: u64,
            sum: [u64; 2],
            /// The depth of the deepest pixel and its place.
            deepest: (u32, [usize; 2]),
            /// The squared distance of the nearest pixel to the middle, and its place.
            middle: Option<(u64, [usize; 2])>,
            others: Vec<[usize; 2]>,
        }
        let (labels, width) = (&self.images[image], self.size[0]);
        let depths = depths(labels, self.size);
        let mut all = vec![Found::default(); self.things.len()];
        let pixels = || {
            labels.iter().enumerate().filter(|(_, label)| **label >= NAMED).flat_map(|(pixel, label)| {
                let numbers = &self.named[(label - NAMED) as usize];
                numbers.iter().map(move |number| (usize::from(*number), pixel, [pixel % width, pixel / width]))
            })
        };
        for (number, pixel, at) in pixels() {
            let found = &mut all[number];
            found.count += 1;
            (0..2).for_each(|k| found.sum[k] += at[k] as u64);
            if depths[pixel] > found.deepest.0 {
                found.deepest = (depths[pixel], at);
            }
        }
        let mut passed = vec![0; all.len()];
        for (number, _, at) in pixels() {
            let found = &mut all[number];
            let away: u64 = (0..2).map(|k| (found.sum[k] / found.count).abs_diff(at[k] as u64).pow(2)).sum();
            if found.middle.is_none_or(|(least, _)| away < least) {
                found.middle = Some((away, at));
            }
            if passed[number] % found.count.div_ceil(MOST_PLACES as u64) == 0 {
                found.others.push(at);
            }
            passed[number] += 1;
        }
        for (number, found) in (0..).zip(all).filter(|(_, found)| found.count > 0) {
            let middle = found.middle.map(|(_, at)| at);
            let places = [found.deepest.1].into_iter().chain(middle).chain(found.others).collect();
            self.things[usize::from(number)].get_or_insert(VisibleThing { number, image, places });
        }
    }

    /// A thing; `None` for one that no pixel shows.
    pub(super) fn thing(&self, number: usize) -> Option<&VisibleThing> {
        self.things.get(number)?.as_ref()
    }

    /// Whether a pixel shows a thing; false outside of the image.
    pub(super) fn shows(&self, thing: &VisibleThing, [x, y]: [i64; 2]) -> bool {
        let label = self.pixel([x, y]).map(|pixel| self.images[thing.image][pixel]);
        label.is_some_and(|label| label >= NAMED && self.named[(label - NAMED) as usize].contains(&thing.number))
    }

    /// The share of a pixel that a text takes from others than `thing`: 0 of the background, half of a sphere without a name, all of another thing.
    pub(super) fn covers(&self, thing: Option<&VisibleThing>, at: [i64; 2]) -> f32 {
        let Some(pixel) = self.pixel(at) else { return 0.0 };
        match self.images.first().map_or(BACKGROUND, |labels| labels[pixel]) {
            BACKGROUND => 0.0,
            _ if thing.is_some_and(|thing| self.shows(thing, at)) => 0.0,
            UNNAMED => 0.5,
            _ => 1.0,
        }
    }

    /// Whether no pixel of a rectangle shows another thing than this one.
    pub(super) fn is_clear_of_others(
        &self,
        thing: &VisibleThing,
        [left, top]: [i64; 2],
        [wide, high]: [i64; 2],
    ) -> bool {
        let pixels = (top..top + high).flat_map(|y| (left..left + wide).map(move |x| [x, y]));
        pixels.into_iter().all(|at| self.covers(Some(thing), at) < 1.0)
    }

    /// The last pixel that shows a thing on the way from one that does.
    pub(super) fn edge(&self, thing: &VisibleThing, from: [usize; 2], [dx, dy]: [i64; 2]) -> [i64; 2] {
        let mut at = from.map(|x| x as i64);
        while self.shows(thing, [at[0] + dx, at[1] + dy]) {
            at = [at[0] + dx, at[1] + dy];
        }
        at
    }

    fn pixel(&self, [x, y]: [i64; 2]) -> Option<usize> {
        let [x, y] = [usize::try_from(x).ok()?, usize::try_from(y).ok()?];
        (x < self.size[0] && y < self.size[1]).then(|| y * self.size[0] + x)
    }
}

/// The distance of each pixel from the nearest one with another label, or outside of the image.
fn depths(labels: &[u32], [width, height]: [usize; 2]) -> Vec<u32> {
    let mut depths = vec![u32::MAX; labels.len()];
    // The neighbours before a pixel in the order of rows; behind it in the other direction.
    let before = [([-1, 0], STEP), ([-1, -1], CORNER), ([0, -1], STEP), ([1, -1], CORNER)];
    let mut pass = |pixel: usize, sign: i64| {
        let at = [(pixel % width) as i64, (pixel / width) as i64];
        for ([dx, dy], step) in before {
            let [x, y] = [at[0] + sign * dx, at[1] + sign * dy];
            let inside = (0..width as i64).contains(&x) && (0..height as i64).contains(&y);
            let other = inside.then(|| y as usize * width + x as usize).filter(|other| labels[*other] == labels[pixel]);
            let depth = other.map_or(0, |other| depths[other]).saturating_add(step);
            depths[pixel] = depths[pixel].min(depth);
        }
    };
    (0..labels.len()).for_each(|pixel| pass(pixel, 1));
    (0..labels.len()).rev().for_each(|pixel| pass(pixel, -1));
    depths
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_deepest_pixel_of_a_thing_is_farthest_from_all_else() {
        // A bar of 9 x 5 pixels, and two spheres of one thing beside it.
        let mut ids = vec![-1; 20 * 10];
        for row in 2..7 {
            ids[row * 20 + 3..row * 20 + 12].fill(0);
            ids[row * 20 + 12..row * 20 + 14].fill(2);
        }
        let things = [("bar".to_owned(), vec![0]), ("none".to_owned(), vec![1]), ("both".to_owned(), vec![0, 2])];
        let visible = VisibleThings::new([20, 10], &things, &[ids]);
        let bar = visible.thing(0).expect("visible");
        assert_eq!(bar.places[0][1], 4, "the row of its middle");
        assert!((5..10).contains(&bar.places[0][0]) && bar.places[1] == [7, 4], "{:?}", bar.places);
        assert!(visible.thing(1).is_none());
        let both = visible.thing(2).expect("visible");
        assert_eq!((visible.edge(bar, [7, 4], [1, 0]), visible.edge(both, [7, 4], [1, 0])), ([11, 4], [13, 4]));
        assert_eq!([[7, 4], [12, 4], [0, 0], [-1, 4]].map(|at| visible.covers(Some(bar), at)), [0.0, 1.0, 0.0, 0.0]);
        assert!(both.places.iter().all(|[x, y]| visible.shows(both, [*x as i64, *y as i64])));
    }
}
