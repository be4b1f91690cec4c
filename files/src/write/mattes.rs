//! The Cryptomatte layers of a frame: each pixel has the ids of the objects that cover most of it, with their coverage. Background has
//! no rank.

use super::cryptomatte::{CHANNELS, LAYERS, MatteHead, RANKS, hexadecimal, id_of};
use crate::read::matte::MatteNames;
use halfline::Frame;
use halfline::frame::coverage::{Cover, Coverage};
use halfline::parallel;
use halfline::quote::count;
use std::collections::BTreeMap;

/// The keyword and the text of the layers of a scene with so many spheres.
pub(super) fn words(mattes: &[MatteNames], spheres: u64) -> Option<(&'static str, String)> {
    let layers: Vec<_> = mattes.iter().map(|names| format!("{}={}", names.layer(), names.digest(spheres))).collect();
    (!layers.is_empty()).then(|| (LAYERS, layers.join(",")))
}

/// Warnings about layers of a frame with these names, in whole sentences.
#[must_use]
pub fn warnings(mattes: &[MatteNames], frame: &Frame) -> Vec<String> {
    let layers = frame.coverage.iter().flat_map(|coverage| mattes.iter().map(move |names| (names, coverage)));
    layers.flat_map(|(names, coverage)| MatteLayer::new(names, coverage).warnings(coverage)).collect()
}

/// Names that one job makes.
const NAMES_PER_JOB: usize = 1 << 8;

/// A layer of a frame.
pub(super) struct MatteLayer {
    pub(super) head: MatteHead,
    /// The visible spheres and their ids in the layer, in the order of the spheres.
    ids: Vec<(u32, u32)>,
}

impl MatteLayer {
    /// The layer of a frame with these names.
    pub(super) fn new(names: &MatteNames, coverage: &Coverage) -> Self {
        let ids = |row: usize| coverage.rows[row].iter().map(|cover| cover.id);
        let mut visible = parallel::collect(coverage.rows.len(), 1, &|rows, out| out.extend(rows.flat_map(ids)));
        parallel::sort(&mut visible, u32::cmp);
        visible.dedup();
        let named = parallel::values(visible.len(), NAMES_PER_JOB, |n| names.name(visible[n]));
        let ids = visible.into_iter().zip(&named).map(|(sphere, name)| (sphere, id_of(name))).collect();
        let manifest = named.into_iter().map(|name| (id_of(&name), name)).map(|(id, name)| (name, hexadecimal(id)));
        Self { head: MatteHead { layer: names.layer().to_owned(), manifest: manifest.collect() }, ids }
    }

    /// Ids and coverage of the ranks of every pixel of a row, of so many samples each.
    pub(super) fn ranked(&self, row: &[Cover], columns: usize, samples: u32) -> Vec<f32> {
        let mut out = vec![0.0; CHANNELS * columns];
        for pixel in row.chunk_by(|a, b| a.column == b.column) {
            let objects = self.objects(pixel);
            let ranks = out[CHANNELS * pixel[0].column as usize..][..CHANNELS].chunks_exact_mut(2);
            for (rank, (id, count)) in ranks.zip(objects) {
                rank.copy_from_slice(&[f32::from_bits(id), count as f32 / samples as f32]);
            }
        }
        out
    }

    /// The objects of a pixel and the samples that show them, most first, then by id.
    fn objects(&self, pixel: &[Cover]) -> Vec<(u32, u32)> {
        let mut objects = BTreeMap::new();
        for cover in pixel {
            let known = self.ids.binary_search_by_key(&cover.id, |(sphere, _)| *sphere);
            if let Ok(place) = known {
                *objects.entry(self.ids[place].1).or_insert(0) += cover.samples;
            }
        }
        let mut objects: Vec<_> = objects.into_iter().collect();
        objects.sort_by_key(|(_, samples)| std::cmp::Reverse(*samples));
        objects
    }

    /// Warnings about names that share an id, and about pixels with more objects than ranks.
    fn warnings(&self, coverage: &Coverage) -> Vec<String> {
        let (layer, mut owners, mut shared) = (&self.head.layer, BTreeMap::new(), Vec::new());
        for (name, id) in &self.head.manifest {
            match owners.get(id) {
                Some(other) => shared.push((*other, name)),
                None => _ = owners.insert(id, name),
            }
        }
        let same = shared.first().map(|(one, other)| {
            let more =
                if shared.len() > 1 { format!(", and {} more pairs do", shared.len() - 1) } else { String::new() };
            format!("{one:?} and {other:?} have the same hash in the layer {layer}, so a matte of one shows both{more}")
        });
        let rows = parallel::blocks(0..coverage.rows.len(), 1, &|rows, _| {
            let pixels = coverage.rows[rows.start].chunk_by(|a, b| a.column == b.column);
            pixels.filter(|pixel| pixel.len() > RANKS && self.objects(pixel).len() > RANKS).count()
        });
        let full: usize = rows.into_iter().sum();
        let full = (full > 0).then(|| {
            let pixels = count(full as u64, "pixel");
            format!("{pixels} of the layer {layer} with more than {RANKS} objects: those that cover least are left out")
        });
        same.into_iter().chain(full).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::read::SceneFrame;
    use halfline::scene::{ImagePlane, Scene, Spheres};
    use halfline::{Camera, Lighting};

    /// A layer named by ids, and its coverage: each row has covers of (column, id, samples).
    fn layer(rows: &[&[[u32; 3]]], samples: u32) -> (MatteLayer, Coverage) {
        let cover = |[column, id, samples]: &[u32; 3]| Cover { column: *column, id: *id, samples: *samples };
        let coverage = Coverage { samples, rows: rows.iter().map(|row| row.iter().map(cover).collect()).collect() };
        let image = ImagePlane { width: 4, height: 3, background: [0.0; 3] };
        let (spheres, lighting) = (Spheres::default(), Lighting::default());
        let frame = SceneFrame::new(1, Scene { camera: Camera::CANONICAL, image, spheres, lighting });
        let names = frame.matte_names(&["id".to_owned()]).expect("ids");
        (MatteLayer::new(&names[0], &coverage), coverage)
    }

    #[test]
    fn objects_are_ranked_by_their_samples() {
        let (matte, coverage) = layer(&[&[[1, 4, 2], [1, 9, 5], [1, 2, 2], [3, 9, 16]]], 16);
        let id = |name: &str| f32::from_bits(id_of(name));
        let mut first = [(id("2"), 0.125), (id("4"), 0.125)];
        // Equal ones by the bits of their ids.
        first.sort_by_key(|(id, _)| id.to_bits());
        let expected = [&[(id("9"), 0.3125)][..], &first].concat();
        let ranked = matte.ranked(&coverage.rows[0], 4, coverage.samples);
        let pixel = |n: usize| ranked[CHANNELS * n..][..CHANNELS].chunks_exact(2).map(|rank| (rank[0], rank[1]));
        assert!(pixel(1).eq(expected.into_iter().chain([(0.0, 0.0); 3])), "{ranked:?}");
        assert!(pixel(3).eq([(id("9"), 1.0)].into_iter().chain([(0.0, 0.0); 5])), "{ranked:?}");
        assert!(pixel(0).chain(pixel(2)).all(|rank| rank == (0.0, 0.0)), "{ranked:?}");
        assert_eq!(matte.head.manifest.keys().collect::<Vec<_>>(), ["2", "4", "9"], "what is visible");
        assert!(matte.warnings(&coverage).is_empty());
    }

    /// The two numbers have the same hash, as mmh3 says.
    #[test]
    fn names_with_one_hash_and_objects_without_a_rank_are_reported() {
        let many: Vec<[u32; 3]> = (0..7).map(|id| [2, id, 1]).collect();
        let (matte, coverage) = layer(&[&[[0, 29517, 1], [0, 87960, 2]], &many], 16);
        let ranked = matte.ranked(&coverage.rows[0], 1, coverage.samples);
        assert_eq!(ranked[..4], [f32::from_bits(0x0aae_224b), 0.1875, 0.0, 0.0], "their samples together");
        let [same, full] = &matte.warnings(&coverage)[..] else { panic!("two warnings") };
        assert!(same.contains("\"29517\" and \"87960\"") && same.contains("CryptoId"), "{same}");
        assert!(full.starts_with("1 pixel of the layer CryptoId with more than 6 objects"), "{full}");
    }
}
