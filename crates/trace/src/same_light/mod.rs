//! Tests whether two ways to render a scene show the same light.
//!
//! Pictures of many seeds are compared by the means of their blocks, so that light that goes to a
//! wrong place is found too. Values that seem to differ are looked at again in pictures of other
//! seeds: one value in some hundreds is off by chance.

mod plain;
pub(crate) mod random_scene;
pub(crate) mod random_shape;

pub(crate) use plain::plain_picture;

use crate::context::Context;
use crate::film::{FilmSample, Limits, one_by_one};
use crate::{Film, Options, Sampler, Sequence, Shard, View, World, camera_ray};
use std::array;
use std::ops::{ControlFlow, Range};

const SIZE: [u32; 2] = [24, 16];
/// Width and height of a block in pixels.
const BLOCK: usize = 8;
/// Number of blocks of a picture.
pub(crate) const BLOCKS: usize = 6;

/// Options of the pictures, but for samples and seed.
const OPTIONS: Options = Options {
    width: SIZE[0],
    height: SIZE[1],
    samples: 0,
    bounces: 8,
    seed: 0,
    sequence: Sequence::Sobol,
    shard: Shard { index: 0, count: 1 },
    view: View::Path,
    clamp: None,
    transparent: false,
    recenter: true,
};

/// Number of pictures of each way that are compared, and that are compared again where a value
/// seems to differ.
const RUNS: [u64; 2] = [8, 48];
/// Difference in standard errors from which a value seems to differ, and from which it does.
const LIMITS: [f64; 2] = [4.0, 5.0];
/// Relative difference that counts as none: nobody sees it in a picture.
const TOLERANCE: f64 = 0.001;

/// Means of the channels of each block.
pub(crate) type Blocks = [[f64; 3]; BLOCKS];

/// A way to render a picture with a seed.
pub(crate) type Way<'a> = &'a dyn Fn(u64) -> Blocks;

/// Means of values over pictures, and their standard errors.
type Means = Vec<(f64, f64)>;

fn to_blocks(pixel: &dyn Fn(u32, u32) -> [f32; 3]) -> Blocks {
    let mut blocks = Blocks::default();
    for y in 0..SIZE[1] {
        for x in 0..SIZE[0] {
            let index = y as usize / BLOCK * (SIZE[0] as usize / BLOCK) + x as usize / BLOCK;
            for (sum, value) in blocks[index].iter_mut().zip(pixel(x, y)) {
                *sum += f64::from(value) / (BLOCK * BLOCK) as f64;
            }
        }
    }
    blocks
}

/// Returns true if the scene has light that light paths may find.
pub(crate) fn has_light_paths(world: &World<'_>) -> bool {
    let camera = &world.scene().cameras[0];
    world.context(&OPTIONS).with_light_paths(camera, &OPTIONS).sensor.is_some()
}

/// Renders as [`World::render`] does on one thread, without light paths or with those that weights
/// take for `rate` in a sample.
pub(crate) fn usual_picture(
    world: &World<'_>,
    samples: u32,
    seed: u64,
    rate: Option<f32>,
) -> Blocks {
    let options = Options { samples, seed, ..OPTIONS };
    let camera = &world.scene().cameras[0];
    let mut context = world.context(&options);
    if let Some(rate) = rate {
        context = Context { rate, ..context.with_light_paths(camera, &options) };
    }
    let sample = one_by_one(|[x, y, sample], splats| {
        let sampler = Sampler::new(options.sequence, options.seed, x, y, sample);
        let ray = camera_ray(camera, SIZE, [x, y], &sampler);
        let found = context.trace(ray, &sampler, &context.camera_hit(&ray));
        context.trace_light(&options, [x, y, sample], &mut |splat| splats.push(splat));
        FilmSample { radiance: found.radiance, covered: found.covered, rays: 0 }
    });
    let mut film = Film::for_options(&options).expect("a film");
    film.take_samples(samples, Limits::NONE, &sample, &mut |_| ControlFlow::Continue(()));
    assert_eq!(film.rejected(), 0);
    let image = film.image();
    to_blocks(&|x, y| {
        let [r, g, b, _] = image.pixels[(y * SIZE[0] + x) as usize];
        [r, g, b]
    })
}

/// The values of pictures: the channels of their blocks, then those of the whole picture.
fn means(way: Way<'_>, seeds: impl Iterator<Item = u64>) -> Means {
    let pictures: Vec<Vec<f64>> = seeds
        .map(|seed| {
            let blocks = way(seed);
            let whole = |channel| blocks.iter().map(|block| block[channel]).sum::<f64>();
            let whole: [f64; 3] = array::from_fn(|channel| whole(channel) / BLOCKS as f64);
            blocks.into_iter().chain([whole]).flatten().collect()
        })
        .collect();
    let of_value = |value| mean(pictures.iter().map(|picture| picture[value]));
    (0..3 * (BLOCKS + 1)).map(of_value).collect()
}

/// Returns the mean of numbers and its standard error.
pub(crate) fn mean(values: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
    let count = values.clone().count() as f64;
    let mean = values.clone().sum::<f64>() / count;
    let squares: f64 = values.map(|value| (value - mean).powi(2)).sum();
    (mean, (squares / (count * (count - 1.0))).sqrt())
}

/// Returns a text if two ways do not show the same light: the values that differ.
pub(crate) fn difference(ways: [Way<'_>; 2]) -> Option<String> {
    let compare = |stage: usize| {
        // No seed is used twice.
        let first = |way: u64| 1000 * (2 * stage as u64 + way);
        let of = |way: usize| means(ways[way], (0..RUNS[stage]).map(|i| first(way as u64) + i));
        let (a, b) = (of(0), of(1));
        let differs = move |&value: &usize| {
            let ((a, error_a), (b, error_b)): ((f64, f64), (f64, f64)) = (a[value], b[value]);
            let off = LIMITS[stage] * error_a.hypot(error_b) + TOLERANCE * b + 1e-6;
            ((a - b).abs() > off).then_some((value, a, b, error_a.hypot(error_b)))
        };
        (0..3 * (BLOCKS + 1)).filter_map(move |value| differs(&value)).collect::<Vec<_>>()
    };
    let suspects = compare(0);
    if suspects.is_empty() {
        return None;
    }
    let suspects: Vec<usize> = suspects.iter().map(|&(value, ..)| value).collect();
    let found = compare(1).into_iter().filter(|(value, ..)| suspects.contains(value));
    let text = found.map(|(value, a, b, error)| {
        let place = match value / 3 {
            BLOCKS => "the picture".to_owned(),
            block => format!("block {block}"),
        };
        let (percent, channel) = (100.0 * (a / b - 1.0), ["red", "green", "blue"][value % 3]);
        format!("{channel} of {place} {a:.5}, not {b:.5} ({percent:+.2} %), within {error:.5}")
    });
    let text: Vec<String> = text.collect();
    (!text.is_empty()).then(|| text.join("; "))
}

/// Returns the numbers of the random scenes to compare: those that `ROTUND_SCENES` names, or else
/// `usual`.
///
/// ```text
/// ROTUND_SCENES=100..1000 cargo test --release -p rotund-trace --lib random_scenes
/// ```
pub(crate) fn scene_numbers(usual: Range<u64>) -> Range<u64> {
    let Ok(named) = std::env::var("ROTUND_SCENES") else { return usual };
    let range = named
        .split_once("..")
        .and_then(|(first, end)| Some(first.parse().ok()?..end.parse().ok()?))
        .filter(|range| !range.is_empty());
    range.unwrap_or_else(|| panic!("ROTUND_SCENES is {named:?}, expected a range as 100..300"))
}
