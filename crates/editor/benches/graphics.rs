//! Measures what a graphics card saves a viewer, if there is one:
//! `cargo bench -p trochoid-editor --features gpu --bench graphics`.
//!
//! A picture of 1920 × 1080 pixels is converted with other display settings, and painted in other colors, by the threads of
//! the editor: on the processor, and on the best driver, of which one that computes on the processor is one, too. Times run
//! from the request to the pixels, without what the window does with them.

use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};
use trochoid::{Access, Buffers, Cache, PackedRecipe, Picture, Plan, Settings, Silent, WorkingSpace};
use trochoid_editor::evaluate::{
    Cards, Channel, Display, Graphics, News, Painter, Painting, Screen, SharedRecipe, Worker,
};

/// Times that each thing is done.
const ROUNDS: usize = 41;

/// What is measured.
struct Scene {
    picture: Arc<Picture>,
    recipe: SharedRecipe,
    space: WorkingSpace,
}

impl Scene {
    fn new() -> Result<Self, Box<dyn std::error::Error>> {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let access = Access::usual(&root.join("graphs")).allowing(&root.join("samples"));
        let graph = trochoid::load_within(&root.join("graphs/great_wave.json"), &[], access)?.graph;
        let output = graph.outputs().iter().position(|output| output.kind == trochoid::Kind::Color).unwrap_or(0);
        let name = graph.outputs()[output].name.clone();
        let plan = Plan::new(&graph, &[&name], 36, &[], &Settings::default())?;
        let mut frame = plan.evaluate(&Buffers::new(), &mut Cache::new(), &Silent)?;
        let picture = Arc::new(frame.pictures.pop().ok_or("no picture")?);
        let recipe = PackedRecipe::evaluate(&graph, output, 36, None, 1 << 28, &mut Cache::new(), &Silent)?;
        Ok(Self { picture, recipe: SharedRecipe(Arc::new(recipe)), space: graph.space() })
    }

    /// Times conversions with settings that change each time.
    fn shown(&self, worker: &Worker, display: impl Fn(f32) -> Display) -> (Vec<Duration>, Arc<Screen>) {
        let mut last = None;
        let times = (0..ROUNDS).map(|round| {
            let started = Instant::now();
            let display = display(round as f32 / ROUNDS as f32);
            worker.show(round as u64 + 1, self.picture.clone(), self.space, display);
            while let Some(news) = worker.wait(Duration::from_secs(60)) {
                if let News::Shown { screen, .. } = news {
                    last = Some(screen);
                    break;
                }
            }
            started.elapsed()
        });
        (times.collect(), last.take().unwrap_or_else(|| Arc::new(Screen { size: [0, 0], pixels: Vec::new() })))
    }

    /// Times paintings, in which `count` of the colors change each time.
    fn painted(&self, painter: &Painter, count: usize) -> Vec<Duration> {
        let own = &self.recipe.0.info().colors;
        let times = (0..ROUNDS).map(|round| {
            let mut colors = own.clone();
            colors.iter_mut().take(count).for_each(|color| color[0] = round as f64 / ROUNDS as f64);
            let (recipe, display) = (self.recipe.clone(), Display::default());
            let started = Instant::now();
            painter.paint(Painting { generation: 1, recipe, colors, spot: None, display });
            let ready = std::iter::repeat_with(|| {
                std::thread::sleep(Duration::from_micros(50));
                painter.news().last()
            });
            let ready = ready.flatten().next().map(|painted| painted.ready);
            ready.map_or(Duration::MAX, |ready| ready - started)
        });
        times.collect()
    }
}

/// Returns the first time, the median of all others, and the smallest, in milliseconds.
fn told(times: &[Duration]) -> String {
    let ms = |time: Duration| 1000.0 * time.as_secs_f64();
    let mut rest = times[1..].to_vec();
    rest.sort_unstable();
    format!("{:7.1} {:7.1} {:7.1}", ms(times[0]), ms(rest[rest.len() / 2]), ms(rest[0]))
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scene = Scene::new()?;
    let card = Graphics::default();
    card.open(Cards::Any);
    println!("{}", card.told().unwrap_or_default());
    println!("{} colors, {} MB", scene.recipe.0.info().names.len(), scene.recipe.0.bytes() >> 20);
    println!("{:32}   first  median  lowest, in ms", "");
    let mut last: Vec<Arc<Screen>> = Vec::new();
    for (name, graphics) in [("processor", Graphics::default()), ("card", card.clone())] {
        let worker = Worker::new(&graphics, || ())?;
        let exposed = |share: f32| Display { exposure: share, ..Display::default() };
        let (times, screen) = scene.shown(&worker, exposed);
        println!("{:32} {}", format!("exposure, {name}"), told(&times));
        last.push(screen);
        let luminance = |share: f32| Display { channel: Channel::Luminance, false_color: true, ..exposed(share) };
        let (times, _) = scene.shown(&worker, luminance);
        println!("{:32} {}", format!("luminance in false color, {name}"), told(&times));
        let painter = Painter::new(&graphics, || ())?;
        println!("{:32} {}", format!("one color, {name}"), told(&scene.painted(&painter, 1)));
        println!("{:32} {}", format!("all colors, {name}"), told(&scene.painted(&painter, usize::MAX)));
    }
    println!("{}", card.told().unwrap_or_default());
    let off = last[0].pixels.iter().zip(&last[1].pixels).map(|(a, b)| a.abs_diff(*b)).max();
    println!("largest difference: {}/255", off.unwrap_or(0));
    Ok(())
}
