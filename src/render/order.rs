//! The order of a scene's spheres that a renderer keeps from frame to frame: a tree over them, for rays from anywhere and for
//! groups that are hidden together.

use crate::certify::grouped::{Boxes, Grouped};
use crate::scene::Spheres;
use crate::scene::list::List;
use crate::scene::same::SameSpheres;
use crate::search::tree::Tree;
use halfline_ground::Shared;
use halfline_ground::memory::check;
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, OnceLock};
use std::thread::Builder;

/// Fewer spheres than this are staged one by one in any frame.
const GROUPING_MIN_SPHERES: usize = 1 << 17;

/// Spheres for each pixel from which on groups are hidden often enough to be worth it.
const GROUPING_MIN_SPHERES_PER_PIXEL: u64 = 8;

/// Frames of the same spheres after which a tree is built for groups alone: it takes as long as it saves in about so many.
const GROUPING_MIN_FRAMES: u64 = 8;

/// The order of the spheres that a renderer saw last, and the orders of other renderers on its device.
#[derive(Default)]
pub(super) struct LastOrder {
    known: Option<Known>,
    shared: Shared<Ordered>,
}

struct Known {
    same: SameSpheres,
    /// The frame in which they were seen first.
    since: u64,
    /// The receiver of the order while another thread builds it.
    built: Option<Receiver<Arc<Ordered>>>,
    order: Option<Arc<Ordered>>,
}

/// Spheres in the order of a tree.
pub(super) struct Ordered {
    same: SameSpheres,
    tree: Arc<Tree>,
    boxes: OnceLock<Boxes>,
}

impl Ordered {
    fn new(spheres: &Spheres) -> Option<Self> {
        // The frame counts only for lists that can be changed, and the order of these is not shared.
        let same = SameSpheres::of(spheres, 0);
        let tree = Arc::new(Tree::new(&spheres.centers, &spheres.radii)?);
        Some(Self { same, tree, boxes: OnceLock::new() })
    }

    /// The order of these spheres, from another renderer if it has one. `None` without spheres.
    fn shared(shared: &Shared<Self>, spheres: &Spheres) -> Option<Arc<Self>> {
        let serves = |order: &Self| order.same.is_kept() && order.same.is_of(spheres, 0);
        shared.or_make(serves, || Self::new(spheres).ok_or(())).ok()
    }

    pub(super) fn groups(&self) -> Grouped<'_> {
        let boxes = self.boxes.get_or_init(|| Boxes::of(&self.tree.spheres));
        Grouped { ids: &self.tree.ids, spheres: &self.tree.spheres, boxes }
    }
}

impl LastOrder {
    /// The tree of these spheres, which is built unless it is known.
    pub(super) fn tree(&mut self, spheres: &Spheres, frame: u64) -> Option<Arc<Tree>> {
        let shared = self.shared.clone();
        let known = self.known(spheres, frame);
        if let Some(built) = known.built.take() {
            known.order = built.recv().ok();
        }
        if known.order.is_none() {
            known.order = Ordered::shared(&shared, spheres);
        }
        known.order.as_ref().map(|order| Arc::clone(&order.tree))
    }

    /// The spheres in groups for a frame of `pixels` pixels; `None` for few spheres for each pixel, and until the tree
    /// is built, which another thread does.
    pub(super) fn groups(&mut self, spheres: &Spheres, frame: u64, pixels: u64) -> Option<Arc<Ordered>> {
        if spheres.len() < GROUPING_MIN_SPHERES || (spheres.len() as u64) < GROUPING_MIN_SPHERES_PER_PIXEL * pixels {
            return None;
        }
        let shared = self.shared.clone();
        let known = self.known(spheres, frame);
        if let Some(order) = known.built.as_ref().and_then(|built| built.try_recv().ok()) {
            (known.order, known.built) = (Some(order), None);
        }
        if known.order.is_none() && known.built.is_none() && frame >= known.since + GROUPING_MIN_FRAMES {
            let what = || format!("the order of {} spheres", spheres.len());
            let lists = spheres.centers.kept().zip(spheres.radii.kept());
            let room = check(Tree::bytes(spheres.len()), what).is_ok();
            known.built = lists.filter(|_| room).and_then(|(centers, radii)| build(shared, centers, radii));
        }
        known.order.clone()
    }

    fn known(&mut self, spheres: &Spheres, frame: u64) -> &mut Known {
        let last = self.known.take().filter(|known| known.same.is_of(spheres, frame));
        let new = || Known { same: SameSpheres::of(spheres, frame), since: frame, built: None, order: None };
        self.known.insert(last.unwrap_or_else(new))
    }

    /// Forgets the spheres that were seen last.
    pub(super) fn forget(&mut self) {
        self.known = None;
    }

    /// The same for another renderer.
    pub(super) fn another(&self) -> Self {
        Self { known: None, shared: self.shared.clone() }
    }
}

/// Builds an order in a thread of its own; `None` where the system allows none.
fn build(shared: Shared<Ordered>, centers: List<[f64; 3]>, radii: List<f64>) -> Option<Receiver<Arc<Ordered>>> {
    let (done, built) = channel();
    let work = move || {
        if let Some(order) = Ordered::shared(&shared, &Spheres { centers, radii, ..Spheres::default() }) {
            order.groups();
            // The receiver is gone where the renderer has other spheres by now.
            let _ = done.send(order);
        }
    };
    Builder::new().name("order".into()).spawn(work).ok().map(|_| built)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::certify::binned::{BinnedScene, Binning};
    use crate::frame::Aov;
    use crate::render::Renderer;
    use crate::scene::camera::{Camera, Lens, Look};
    use crate::scene::{ImagePlane, Scene};
    use crate::settings::{Backend, Settings, Tolerance};
    use crate::testing::Rng;
    use crate::view::raster::Raster;
    use crate::view::{Records, View};
    use crate::window::Window;
    use glam::DVec3;
    use halfline_ground::memory::Pool;

    const SIZE: [u32; 2] = [96, 72];

    /// So many spheres in a cube that rays end in the first third of it, and some that are large, far away, or behind.
    fn cloud(others: u32) -> Spheres {
        let mut rng = Rng(36);
        let mut spheres = Spheres::default();
        for n in 0..GROUPING_MIN_SPHERES {
            let place = [0; 3].map(|_| rng.between(0.0, 1.0));
            spheres.push(place, rng.between(0.004, 0.012), (n % 3 == 0).then_some([0.2, 0.5, 0.9]));
        }
        for n in 0..others {
            let far = rng.decade(0.0, 3.0);
            let place = [0; 3].map(|_| rng.between(-far, far));
            spheres.push(place, if n % 9 == 0 { 0.3 } else { 0.01 }, None);
        }
        spheres.share();
        spheres
    }

    fn scenes() -> Vec<Scene> {
        let [mixed, alone] = [200, 0].map(cloud);
        let vfov = |degrees| Lens::Vfov { degrees, distance: 1.0 };
        let middle = DVec3::splat(0.5);
        let views = [
            (&mixed, DVec3::new(2.2, 1.6, 2.9), vfov(32.0)),
            (&mixed, DVec3::new(0.52, 0.48, 0.51), vfov(100.0)),
            (&mixed, DVec3::new(1.05, 0.5, 0.5), vfov(60.0)),
            (&mixed, DVec3::new(2.2, 1.6, 2.9), Lens::Orthographic { height: 1.5 }),
            // All depths are nearly equal, so they are relative to a reference; and the centres need double-double.
            (&alone, DVec3::new(220.0, 160.0, 290.0), vfov(0.3)),
            (&alone, DVec3::new(2.2e7, 1.6e7, 2.9e7), vfov(3e-6)),
            // Those in front alone would have a reference; with those that they hide there is none.
            (&alone, DVec3::new(0.5, 0.5, 3.6), vfov(20.0)),
        ];
        let scene = |(spheres, eye, lens): (&Spheres, DVec3, Lens)| Scene {
            camera: Camera { eye, look: Look::At(middle), up: DVec3::Y, lens },
            image: ImagePlane { width: SIZE[0], height: SIZE[1], background: [0.1; 3] },
            spheres: spheres.clone(),
            lighting: Default::default(),
        };
        views.into_iter().map(scene).collect()
    }

    #[test]
    fn frames_without_hidden_groups_have_the_same_bits() {
        let aovs = vec![Aov::Color, Aov::Id, Aov::Distance, Aov::Normal, Aov::Certainty];
        let plain = Settings { backend: Backend::Cpu, aovs, ..Settings::default() };
        let crop = Some(Window { x0: 13, y0: 5, x1: 90, y1: 50 });
        let kinds = [
            plain.clone(),
            Settings { window: crop, ..plain.clone() },
            Settings { samples: 4, silhouette: true, ..plain.clone() },
            Settings { tolerance: Some(Tolerance::new(0.2).expect("a tolerance")), ..plain },
        ];
        for (n, scene) in scenes().iter().enumerate() {
            for settings in &kinds {
                let mut renderer = Renderer::new(settings).expect("the CPU path");
                let all = renderer.render(scene, settings).expect("a frame");
                // As after some frames, or with light.
                renderer.order.tree(&scene.spheres, renderer.frames).expect("a tree");
                let pixels = u64::from(all.width) * u64::from(all.height);
                let groups = renderer.order.groups(&scene.spheres, renderer.frames + 1, pixels);
                assert!(groups.is_some(), "scene {n}: the spheres are the same");
                let some = renderer.render(scene, settings).expect("a frame");
                assert!(all.ids().iter().any(|id| *id >= 0), "scene {n} shows something");
                assert!(all.buffers == some.buffers, "scene {n}: {settings:?}");
            }
        }
    }

    /// Negative control of the test above: groups are left out there.
    #[test]
    fn hidden_groups_are_left_out() {
        let pool = Pool::default();
        for (n, scene) in scenes().iter().enumerate() {
            let order = Ordered::new(&scene.spheres).expect("a tree");
            let view =
                View::for_rays(scene, Raster::centres(Window::full(SIZE[0], SIZE[1])), Records::None).expect("a view");
            let of = |groups| {
                let binned =
                    BinnedScene::new(&Binning { groups, ..Binning::of(scene, &view, 1e-5, &pool) }).expect("a stage");
                binned.expect("bounds")
            };
            let (all, some) = (of(None), of(Some(order.groups())));
            println!(
                "scene {n}: {} of {} spheres, {} of {} general",
                some.projected_count,
                all.projected_count,
                some.generals.len(),
                all.generals.len()
            );
            // From 2e7 cubes away f32 does not tell depths within the cube apart, so nothing is surely hidden.
            assert!(2 * some.projected_count < all.projected_count && some.projected_count > 0 || n == 5, "scene {n}");
            assert_eq!(all.projection.depth, some.projection.depth, "scene {n}: the reference");
            assert_eq!(all.projection.depth > 0.0, [4, 5].contains(&n), "scene {n}: a reference");
        }
    }

    #[test]
    fn an_order_is_that_of_the_last_spheres() {
        let (mut last, spheres) = (LastOrder::default(), cloud(200));
        let mut changed = spheres.clone();
        changed.radii.to_mut()[0] = 2.0;
        changed.share();
        let first = last.tree(&spheres, 1).expect("a tree");
        assert!(Arc::ptr_eq(&first, &last.tree(&spheres.clone(), 9).expect("a tree")), "it is kept");
        assert!(last.groups(&changed, 10, 1).is_none(), "other spheres, seen for the first time");
        assert!(
            (11..=10 + GROUPING_MIN_FRAMES).all(|frame| last.groups(&changed, frame, 1).is_none()),
            "built beside the frames"
        );
        let tree = last.tree(&changed, 20).expect("a tree");
        assert!(tree.spheres.iter().any(|sphere| sphere[3] == 2.0), "of the changed ones");
        assert!(last.groups(&changed, 21, 1).is_some() && last.groups(&changed, 22, 1 << 40).is_none());
    }
}
