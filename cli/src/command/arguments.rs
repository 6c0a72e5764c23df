//! The words of the command line.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};

use crate::assemble::integrators::INTEGRATORS;
use crate::modules::Modules;
use crate::scene::{OptionKind, Override};

/// Runs scenes of physics, and says what they are made of.
#[derive(Parser, Debug)]
#[command(
    name = "vesper",
    version,
    after_help = "Examples:
  vesper run examples/scenes/solar-system.toml
  vesper explain examples/scenes/c5-spider-web.toml
  vesper laws gravity

Exit status: 0 done; 2 the scene or the arguments are wrong, and nothing was run or written;
3 the run failed (a NaN, a step that cannot be taken), or something could not be written;
130 the run was stopped by Ctrl-C, and what it had come to is written as at its end."
)]
pub struct Arguments {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// What to do.
#[derive(Subcommand, Debug)]
pub enum Command {
    /// Runs a scene to its end, and says what came of it
    #[command(after_help = "Examples:
  vesper run examples/scenes/c7a-rest.toml
  vesper run scene.toml --end 10 --step 1e-4 --integrator runge_kutta_4 --out results
  vesper run scene.toml --set laws.gravity.softening=0.1 --set domains.springs.stiffness.0=30
  vesper run scene.toml --json > result.json
  vesper run scene.toml --end 20 --out more --resume results/checkpoint.json

--out DIR writes a table (DOMAIN.csv) for each domain that shows columns, trajectories.svg, summary.json and
checkpoint.json; files of these names that are in DIR are overwritten. Shown are the columns of engine.observe, or else
those that laws move: bodies have a table of positions and velocities, springs have none. All numbers are in SI:
positions in m, velocities in m/s; `vesper laws NAME` tells the units of others.

A path of --set is names between dots: engine.step, constants.gravity, laws.NAME.PARAMETER, domains.NAME.COLUMN.ROW.")]
    Run(Run),
    /// Measures speed against error: for a scene, or for a file of cases with known answers
    #[command(after_help = "Examples:
  vesper study examples/scenes/c7g-soft-spring-gravity.toml
  vesper study scene.toml --integrators leapfrog,gauss_radau_15 --steps 0.1,0.01 --out results
  vesper study scene.toml --error 1e-6 --of bodies.position --fps 60
  vesper study scene.toml --precisions f32,f64 --compensated --of bodies.position
  vesper study examples/references.json --cases kepler_e0.9,pythagorean
  vesper study examples/references.json --out results --resume results/study.json

A scene needs no known answer: two unlike integrators at tight tolerances make one, and the table says how far they are
apart. Each integrator goes from coarse to fine until it comes no nearer, or until a run would take longer than --limit.

--out DIR writes study.json, study.csv and a diagram of error against time (NAME.svg) for the scene or for each case;
files of these names that are in DIR are overwritten. Errors are the largest over all times and rows, each quantity by its
largest magnitude, or by the scale that a case gives.")]
    Study(Study),
    /// Runs a scene with many values: an ensemble, in shards if it is large, with one table and one picture at the end
    #[command(after_help = SWEEP, mut_arg("threads", |threads| threads.help("Threads of each run [default: 1]")))]
    Sweep(Sweep),
    /// Prints the law graph of a scene: who runs, in which order, why, where, and who does not
    #[command(after_help = "Examples:
  vesper explain examples/scenes/solar-system.toml
  vesper explain examples/scenes/c5-spider-web.toml --dot | dot -Tsvg > graph.svg")]
    Explain(Explain),
    /// Lists the stock laws, or prints one: equation, source, limits, what it touches, parameters
    #[command(after_help = "Examples:
  vesper laws
  vesper laws gravity")]
    Laws {
        /// The law; all where none is named.
        name: Option<String>,
        /// A folder of law modules, which are listed too; may be given many times
        #[arg(long = "laws", value_name = "DIR")]
        folders: Vec<PathBuf>,
    },
}

/// What `vesper sweep --help` says behind the options.
const SWEEP: &str = "Examples:
  vesper sweep scene.toml --vary engine.step=0.001:0.1:20:log
  vesper sweep scene.toml --vary engine.step=1e-3:1e-1:9:log --vary engine.integrator=[leapfrog,runge_kutta_4] --out results
  vesper sweep scene.toml --vary domains.springs.stiffness.0=1:100:64 --measure bodies.position[0].x --out results --shard 2/4
  vesper sweep --collect --out results

--vary PATH=VALUES, where PATH is that of `vesper run --set`, and VALUES are
  FIRST:LAST:COUNT       so many numbers at equal distances, both ends included
  FIRST:LAST:COUNT:log   the same by equal factors
  [V,V,..]               these: numbers, words, or anything that --set takes; vectors as [[0,0,-9.81],[0,0,-1.62]]
Several --vary make every combination. Runs count from 1, and the last --vary changes fastest.

--measure DOMAIN.PROPERTY[WHICH].COMPONENT is a number at the end of each run, in SI: WHICH is a row (its number from 0, or its
label) or min, max, mean over all rows; COMPONENT is x, y, z, w or length, and a scalar has none. Quotes keep a shell's hands
off the brackets: --measure 'bodies.velocity[max].length'

--out DIR holds a file for each run (runs/NUMBER.json), manifest.json, and at the end table.csv and sweep.svg. What is there is
not run again, so the same command goes on where it was stopped. A folder holds one sweep, and refuses another. Tables are the
same, bit for bit, in one run or in shards, on any number of threads; the time that a run took is in its own file only.

--shard K/N makes the runs K, K+N, K+2N and so on. Shards need nothing of each other but the folder, not even the same machine;
the last one to end makes table and picture. As an array of Slurm:
  #SBATCH --array=1-16
  vesper sweep scene.toml --vary engine.step=1e-4:1e-1:64:log --shard $SLURM_ARRAY_TASK_ID/16 --out results

A run that fails leaves its reason, and stops no other; then the exit status is 3, of a shard where one of its own runs failed.
--limit gives up what takes longer, so that one run that never ends keeps no others waiting; what is given up is the clock's to say.
What failed is not run again, unless --retry says so.";

fn integrators() -> String {
    let names: Vec<&str> = INTEGRATORS.iter().map(|known| known.name).collect();
    format!("Integrator: {}", names.join(", "))
}

/// A scene, and what is changed of it.
#[derive(Args, Debug)]
pub struct SceneArguments {
    /// The scene file
    pub scene: PathBuf,
    /// Changes of it.
    #[command(flatten)]
    pub settings: Settings,
}

/// How a scene is run, where that is not as it says.
#[derive(Args, Debug)]
pub struct Settings {
    // The list itself, so that the help knows all of them.
    #[arg(long, value_name = "NAME", help = integrators())]
    /// The integrator.
    pub integrator: Option<String>,
    /// Number type of the state
    #[arg(long, value_name = "f32|f64|double-double")]
    pub precision: Option<String>,
    /// Where laws run that do not say
    #[cfg_attr(not(feature = "gpu"), arg(long, value_name = "auto|cpu|parallel"))]
    #[cfg_attr(feature = "gpu", arg(long, value_name = "auto|cpu|parallel|gpu|fastest"))]
    pub backend: Option<String>,
    /// Modules of laws.
    #[command(flatten)]
    pub modules: ModuleArguments,
    /// Threads, strictness, single values.
    #[command(flatten)]
    pub changes: Changes,
}

/// What any command may change of a scene.
#[derive(Args, Debug)]
pub struct Changes {
    /// Threads for parallel laws [default: all cores]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub threads: Option<String>,
    /// Every law must run: one that lacks its data is a mistake of the scene
    #[arg(long)]
    pub strict: bool,
    /// Sets one value of the scene, as in engine.step=1e-3; may be given many times
    #[arg(long = "set", value_name = "PATH=VALUE", allow_hyphen_values = true)]
    pub set: Vec<String>,
}

/// Where the modules of a scene's laws may come from.
#[derive(Args, Debug)]
pub struct ModuleArguments {
    /// A folder of law modules (`module = ".."` in scenes); may be given many times, and those of VESPER_LAW_PATH come after
    // `vesper study --laws` was there first.
    #[arg(long = "laws", value_name = "DIR")]
    pub folders: Vec<PathBuf>,
    /// Lets the scene name files of modules: their code runs with your rights
    #[arg(long)]
    pub allow_module_files: bool,
}

impl ModuleArguments {
    /// Where modules may come from.
    pub fn modules(&self) -> Modules {
        Modules::new(&self.folders, self.allow_module_files)
    }
}

/// `vesper run`.
#[derive(Args, Debug)]
pub struct Run {
    /// The scene and its changes.
    #[command(flatten)]
    pub scene: SceneArguments,
    /// Time to stop at, in s
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub end: Option<String>,
    /// Fixed step, in s
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub step: Option<String>,
    /// Folder for tables, picture, summary and checkpoint; those in it from an earlier run are overwritten
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Write every N-th frame [default: at most 1000 frames and 200000 lines in all]
    #[arg(long, value_name = "N", requires = "out", allow_negative_numbers = true)]
    pub every: Option<String>,
    /// Print one JSON object on standard output, and nothing else there
    #[arg(long)]
    pub json: bool,
    /// No progress bar and no summary
    #[arg(long)]
    pub quiet: bool,
    /// Go on from a checkpoint of the same scene
    #[arg(long, value_name = "FILE")]
    pub resume: Option<PathBuf>,
}

/// `vesper study`.
#[derive(Args, Debug)]
pub struct Study {
    /// The scene file, or a file of cases (.json)
    #[arg(value_name = "SCENE|CASES")]
    pub file: PathBuf,
    /// Time to stop at, in s
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub end: Option<String>,
    /// Threads, strictness, single values.
    #[command(flatten)]
    pub changes: Changes,
    /// Integrators to try [default: all]
    #[arg(long, value_name = "NAME,..", value_delimiter = ',')]
    pub integrators: Vec<String>,
    /// Fixed steps to try, in s [default: halves of the scene's, or of one that suits it]
    #[arg(long, value_name = "S,..", value_delimiter = ',', allow_negative_numbers = true)]
    pub steps: Vec<String>,
    /// Tolerances of adaptive integrators to try [default: tenths]
    #[arg(long, value_name = "T,..", value_delimiter = ',', allow_negative_numbers = true)]
    pub tolerances: Vec<String>,
    /// Number types to try [default: f64, and double-double where rounding limits an integrator that gains by it]
    #[arg(long, value_name = "f32,f64,double-double", value_delimiter = ',')]
    pub precisions: Vec<String>,
    /// Every run also with the rounding errors of the state kept and added back [default: those that rounding limits]
    #[arg(long)]
    pub compensated: bool,
    #[cfg_attr(not(feature = "gpu"), doc = "Backends to try: auto, cpu, parallel")]
    #[cfg_attr(feature = "gpu", doc = "Backends to try: auto, cpu, parallel, gpu")]
    #[arg(long, value_name = "B,..", value_delimiter = ',', default_value = "auto")]
    pub backends: Vec<String>,
    /// The largest error: tell the cheapest way to it, with the evidence
    #[arg(long, value_name = "E", allow_negative_numbers = true)]
    pub error: Option<String>,
    /// Frames in a second, each of which is to take no longer than it lasts
    #[arg(long, value_name = "N", requires = "error", allow_negative_numbers = true)]
    pub fps: Option<String>,
    /// Write the choice into the scene file
    #[arg(long, requires = "error", conflicts_with_all = ["end", "set", "laws"])]
    pub write: bool,
    /// Switch off each law in turn, and tell what it does to the end, and what it costs
    #[arg(long, conflicts_with_all = ["integrators", "steps", "tolerances", "compensated", "fps", "resume"])]
    pub laws: bool,
    /// A folder of law modules, as `--laws` of `vesper run`; may be given many times
    #[arg(long, value_name = "DIR")]
    pub laws_from: Vec<PathBuf>,
    /// What is compared, as DOMAIN.PROPERTY [default: all that the scene shows]
    #[arg(long, value_name = "NAME,..", value_delimiter = ',')]
    pub of: Vec<String>,
    /// Cases to try [default: all of the file]
    #[arg(long, value_name = "NAME,..", value_delimiter = ',')]
    pub cases: Vec<String>,
    /// Time that one run may take, in s
    #[arg(long, value_name = "S", default_value = "1", allow_negative_numbers = true)]
    pub limit: String,
    /// Folder for study.json, study.csv and diagrams
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Print one JSON object on standard output, and nothing else there
    #[arg(long)]
    pub json: bool,
    /// No progress bar and no table
    #[arg(long)]
    pub quiet: bool,
    /// Take the runs of an earlier study.json as they are
    #[arg(long, value_name = "FILE")]
    pub resume: Option<PathBuf>,
}

/// `vesper sweep`.
#[derive(Args, Debug)]
pub struct Sweep {
    /// The scene file; with --collect it may be left out
    #[arg(required_unless_present = "collect", requires = "vary")]
    pub scene: Option<PathBuf>,
    /// What varies, as in engine.step=0.01:0.1:10; may be given many times
    #[arg(long, value_name = "PATH=VALUES", allow_hyphen_values = true)]
    pub vary: Vec<String>,
    /// What is told of each run, as in bodies.position[0].z; may be given many times
    #[arg(long, value_name = "WHAT", allow_hyphen_values = true)]
    pub measure: Vec<String>,
    /// Folder for the runs, the table and the picture; what is in it is not run again
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Only the K-th of N shares of the runs
    #[arg(long, value_name = "K/N", requires = "out", allow_hyphen_values = true)]
    pub shard: Option<String>,
    /// Runs at the same time, each on one thread unless the scene or --threads says more [default: all cores]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub jobs: Option<String>,
    /// Time that one run may take, in s; one that takes longer fails [default: as long as it takes]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub limit: Option<String>,
    /// Run again what failed
    #[arg(long, requires = "out")]
    pub retry: bool,
    /// Only table and picture of the runs that are in the folder; all of them must be there
    #[arg(long, requires = "out", conflicts_with_all = ["shard", "retry", "jobs", "limit"])]
    pub collect: bool,
    /// Time to stop at, in s
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub end: Option<String>,
    /// Fixed step, in s
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub step: Option<String>,
    /// Changes that all runs have.
    #[command(flatten)]
    pub settings: Settings,
    /// Print one JSON object on standard output, and nothing else there
    #[arg(long)]
    pub json: bool,
    /// No progress bar and no table
    #[arg(long)]
    pub quiet: bool,
}

/// `vesper explain`.
#[derive(Args, Debug)]
pub struct Explain {
    /// The scene and its changes.
    #[command(flatten)]
    pub scene: SceneArguments,
    /// In the language of Graphviz
    #[arg(long)]
    pub dot: bool,
}

impl Changes {
    /// As changes of the scene; those of `--set` last.
    fn overrides(&self) -> impl Iterator<Item = Override> {
        let settings = [
            option("--threads", "threads", self.threads.as_ref(), OptionKind::Number),
            option("--strict", "strict", self.strict.then(String::new).as_ref(), OptionKind::Flag),
        ];
        settings.into_iter().flatten().chain(self.set.iter().cloned().map(Override::Set))
    }
}

impl Settings {
    /// All changes of the scene, so that they are checked as the scene is; those of `--set` last.
    pub fn overrides(&self) -> Vec<Override> {
        use OptionKind::Word;
        let settings = [
            option("--integrator", "integrator", self.integrator.as_ref(), Word),
            option("--precision", "precision", self.precision.as_ref(), Word),
            option("--backend", "backend", self.backend.as_ref(), Word),
        ];
        settings.into_iter().flatten().chain(self.changes.overrides()).collect()
    }
}

impl Run {
    /// All changes of the scene.
    pub fn overrides(&self) -> Vec<Override> {
        let times = times(self.end.as_ref(), self.step.as_ref());
        self.scene.settings.overrides().into_iter().chain(times).collect()
    }
}

impl Sweep {
    /// All changes of the scene, but for what varies.
    pub fn overrides(&self) -> Vec<Override> {
        let times = times(self.end.as_ref(), self.step.as_ref());
        self.settings.overrides().into_iter().chain(times).collect()
    }
}

impl Study {
    /// All changes of the scene.
    pub fn overrides(&self) -> Vec<Override> {
        let end = option("--end", "end", self.end.as_ref(), OptionKind::Seconds);
        end.into_iter().chain(self.changes.overrides()).collect()
    }
}

fn times(end: Option<&String>, step: Option<&String>) -> impl Iterator<Item = Override> {
    let times = [option("--end", "end", end, OptionKind::Seconds), option("--step", "step", step, OptionKind::Seconds)];
    times.into_iter().flatten()
}

fn option(option: &'static str, key: &'static str, text: Option<&String>, kind: OptionKind) -> Option<Override> {
    text.map(|text| Override::Engine { option, key, text: text.clone(), kind })
}
