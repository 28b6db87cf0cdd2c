//! A light tree: sampling one of many emitters by a bound on its irradiance at a point.
//!
//! Source: A. Conty Estevez, C. Kulla, "Importance Sampling of Many Lights with Adaptive Tree
//! Splitting", HPG 2018; without the splitting.

use glam::{Vec3, Vec4};
use rotund_geometry::Aabb;

/// Bounds of a group of emitters.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent {
    pub(super) bounds: Aabb,
    /// Sum of luminance times area.
    pub(super) power: f32,
    /// Common normal of all emitters up to its sign, or zero.
    pub(super) normal: Vec3,
}

/// A binary tree over emitters, with nodes in depth-first order; the root is node 0.
#[derive(Clone, Debug, Default)]
pub(super) struct LightTree {
    nodes: Vec<Node>,
    /// For each emitter, its path from the root: bit `depth` is set if it is in the second child
    /// there.
    trails: Vec<u64>,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    power: f32,
    normal: Vec3,
    /// Center of the bounds, and the square of the distance of its corners.
    center: Vec3,
    radius2: f32,
    kind: Kind,
}

#[derive(Clone, Copy, Debug)]
enum Kind {
    /// Index of the second child; the first follows its parent.
    Fork(u32),
    /// Index of the emitter.
    Leaf(u32),
}

/// A point that lights are sampled for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Receiver {
    /// The point, in world space.
    pub position: Vec3,
    /// Shading normal, of unit length, where only light from above the surface counts; `None`
    /// inside of a medium and on surfaces that transmit light. It must be the same for all
    /// densities of one vertex.
    pub normal: Option<Vec3>,
}

/// Depth below which groups are halved by count, so that a trail has at most 32 bits more than
/// this.
const GREEDY_DEPTH: usize = 30;
/// Number of bins along each axis, between which a group may be split.
const BINS: usize = 12;

impl LightTree {
    /// Builds a tree of the emitters with power; the others are never sampled.
    pub(super) fn new(emitters: &[Extent]) -> Self {
        let mut tree = Self { nodes: Vec::new(), trails: vec![0; emitters.len()] };
        let mut members: Vec<u32> =
            (0..emitters.len() as u32).filter(|&e| emitters[e as usize].power > 0.0).collect();
        if !members.is_empty() {
            tree.build(emitters, &mut members, 0, 0);
        }
        tree
    }

    fn build(&mut self, emitters: &[Extent], members: &mut [u32], depth: usize, trail: u64) {
        let extent = members
            .iter()
            .map(|&e| emitters[e as usize])
            .reduce(Extent::union)
            .expect("a group has members");
        let index = self.nodes.len();
        if let &mut [emitter] = members {
            self.nodes.push(Node::new(&extent, Kind::Leaf(emitter)));
            self.trails[emitter as usize] = trail;
            return;
        }
        self.nodes.push(Node::new(&extent, Kind::Fork(0)));
        let middle = split(emitters, members, depth);
        let (first, second) = members.split_at_mut(middle);
        self.build(emitters, first, depth + 1, trail);
        self.nodes[index].kind = Kind::Fork(self.nodes.len() as u32);
        self.build(emitters, second, depth + 1, trail | 1 << depth);
    }

    /// Returns an estimate of the irradiance of all emitters together: an upper bound but for the
    /// variation of the distance within a group, without occlusion.
    pub(super) fn importance(&self, receiver: &Receiver) -> f32 {
        self.nodes.first().map_or(0.0, |root| importances([root; 2], receiver)[0])
    }

    /// Samples an emitter. Returns its index and probability, or `None` if no emitter can
    /// illuminate the receiver.
    pub(super) fn choose(&self, receiver: &Receiver, mut u: f32) -> Option<(u32, f32)> {
        let mut index = 0;
        let mut chance = 1.0;
        loop {
            match self.nodes.get(index)?.kind {
                Kind::Leaf(emitter) => return Some((emitter, chance)),
                Kind::Fork(second) => {
                    let share = self.share_of_first(index, second, receiver)?;
                    if u < share {
                        u /= share;
                        chance *= share;
                        index += 1;
                    } else {
                        u = (u - share) / (1.0 - share);
                        chance *= 1.0 - share;
                        index = second as usize;
                    }
                    u = u.min(1.0_f32.next_down());
                }
            }
        }
    }

    /// Returns the probability that [`Self::choose`] returns this emitter, which must have power.
    pub(super) fn chance(&self, receiver: &Receiver, emitter: u32) -> f32 {
        let mut index = 0;
        let mut chance = 1.0;
        let mut trail = self.trails[emitter as usize];
        while let Some(Node { kind: Kind::Fork(second), .. }) = self.nodes.get(index) {
            let Some(share) = self.share_of_first(index, *second, receiver) else { return 0.0 };
            if trail & 1 == 0 {
                chance *= share;
                index += 1;
            } else {
                chance *= 1.0 - share;
                index = *second as usize;
            }
            trail >>= 1;
        }
        chance
    }

    fn share_of_first(&self, index: usize, second: u32, receiver: &Receiver) -> Option<f32> {
        let children = [&self.nodes[index + 1], &self.nodes[second as usize]];
        let [a, b] = importances(children, receiver);
        (a + b > 0.0).then(|| a / (a + b))
    }
}

impl Extent {
    fn union(self, other: Self) -> Self {
        let together = self.normal.dot(other.normal).abs() > 1.0 - 1e-3;
        Self {
            bounds: self.bounds.union(other.bounds),
            power: self.power + other.power,
            normal: if together { self.normal } else { Vec3::ZERO },
        }
    }
}

impl Node {
    fn new(extent: &Extent, kind: Kind) -> Self {
        let Extent { bounds, power, normal } = *extent;
        let radius2 = 0.25 * (bounds.max - bounds.min).length_squared();
        Self { power, normal, center: bounds.center(), radius2, kind }
    }
}

/// Returns the importance of two groups for a receiver: 0 only if no light can reach it. Both in
/// two lanes take little longer than one.
fn importances(nodes: [&Node; 2], receiver: &Receiver) -> [f32; 2] {
    let lanes = |[a, b]: [f32; 2]| Vec4::new(a, b, 0.0, 0.0);
    let axes = |[a, b]: [Vec3; 2]| [lanes([a.x, b.x]), lanes([a.y, b.y]), lanes([a.z, b.z])];
    let at = |point: Vec3| point.to_array().map(Vec4::splat);
    let dot = |a: [Vec4; 3], b: [Vec4; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let radius2 = lanes(nodes.map(|node| node.radius2));
    let ([x, y, z], from) = (axes(nodes.map(|node| node.center)), at(receiver.position));
    let to = [x - from[0], y - from[1], z - from[2]];
    let distance2 = dot(to, to);
    let power = lanes(nodes.map(|node| node.power));
    let near = power / distance2.max(radius2).max(Vec4::splat(f32::MIN_POSITIVE));
    // Cosine and sine of the half angle that the bounding sphere subtends.
    let sine2 = radius2 / distance2;
    let spread = [(1.0 - sine2).sqrt(), sine2.sqrt()];
    let distance = distance2.sqrt();
    let direction = to.map(|to| to / distance);
    let arriving = receiver.normal.map_or(Vec4::ONE, |normal| {
        widened_cosine(dot(at(normal), direction), spread).max(Vec4::ZERO)
    });
    let normal = axes(nodes.map(|node| node.normal));
    let [x, y, z] = normal.map(|normal| normal.cmpeq(Vec4::ZERO));
    let leaving = widened_cosine(dot(normal, direction).abs(), spread);
    let leaving = Vec4::select(x & y & z, Vec4::ONE, leaving);
    let inside = distance2.cmple(radius2);
    let [a, b, ..] = Vec4::select(inside, near, near * arriving * leaving).to_array();
    [a, b]
}

/// Returns the largest cosine within a cone of half angle `[cosine, sine]` about a direction of
/// this cosine: the cosine of the difference of the angles, or 1 if the half angle is larger.
fn widened_cosine(cosine: Vec4, [spread_cosine, spread_sine]: [Vec4; 2]) -> Vec4 {
    let sine = ((1.0 - cosine) * (1.0 + cosine)).max(Vec4::ZERO).sqrt();
    let widened = cosine * spread_cosine + sine * spread_sine;
    Vec4::select(cosine.cmpge(spread_cosine), Vec4::ONE, widened)
}

/// Returns the union of those that are there.
fn join(a: Option<Extent>, b: Option<Extent>) -> Option<Extent> {
    match (a, b) {
        (Some(a), Some(b)) => Some(a.union(b)),
        (a, b) => a.or(b),
    }
}

/// Partitions members into two groups that are not empty, and returns the size of the first.
fn split(emitters: &[Extent], members: &mut [u32], depth: usize) -> usize {
    let center = |e: &u32| emitters[*e as usize].bounds.center();
    let centers = Aabb::from_points(members.iter().map(center));
    let mut best: Option<(f32, usize, f32)> = None;
    let axes = if depth < GREEDY_DEPTH { 0..3 } else { 0..0 };
    for axis in axes {
        let (low, high) = (centers.min[axis], centers.max[axis]);
        let planes: [f32; BINS - 1] =
            std::array::from_fn(|i| low + (high - low) * ((i + 1) as f32 / BINS as f32));
        // The groups between neighbouring planes.
        let mut bins = [None; BINS];
        for e in &*members {
            let place = center(e)[axis];
            let bin = &mut bins[planes.iter().filter(|&&plane| place >= plane).count()];
            *bin = join(*bin, Some(emitters[*e as usize]));
        }
        let mut behind = bins;
        for bin in (1..BINS).rev() {
            behind[bin - 1] = join(behind[bin - 1], behind[bin]);
        }
        let mut before = None;
        for (bin, &plane) in planes.iter().enumerate() {
            before = join(before, bins[bin]);
            let (Some(a), Some(b)) = (before, behind[bin + 1]) else { continue };
            // Power times half area, so that bright groups are small. Groups with a common normal
            // count less, because their bounds are tighter.
            let cost = |e: Extent| {
                let normals = if e.normal == Vec3::ZERO { 2.0 } else { 1.0 };
                e.power * normals * e.bounds.half_area()
            };
            let cost = cost(a) + cost(b);
            if best.is_none_or(|(least, ..)| cost < least) {
                best = Some((cost, axis, plane));
            }
        }
    }
    if let Some((_, axis, plane)) = best {
        let is_second = |e: &u32| center(e)[axis] >= plane;
        // A stable sort keeps the order of members, so the tree is deterministic.
        members.sort_by_key(is_second);
        return members.partition_point(|e| !is_second(e));
    }
    members.len() / 2
}
