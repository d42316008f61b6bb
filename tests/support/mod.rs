//! A folder to run the program in, as a user would.
#![allow(dead_code)] // each test program uses its share

pub mod browser;

use assert_cmd::Command;
use assert_cmd::assert::Assert;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::{Duration, Instant};

/// A script that renders in no time.
pub const BALL: &str = "sphere(1.0)";

/// A script that takes much longer than any test waits, at 2000x2000 pixels.
pub const SLOW: &str = "
    import \"std/fractal\" as fractal;
    let noise = fractal::fbm(gradient(7), #{ octaves: 12, lacunarity: 2.1, hurst: 0.4 }).scaled(4.0);
    sphere(1.0) - 0.2 * noise
";

/// A temporary folder with scripts in it.
pub struct Bench {
    folder: tempfile::TempDir,
    /// Where the program keeps analyses.
    pub cache: tempfile::TempDir,
}

impl Bench {
    /// With these files.
    pub fn new(files: &[(&str, &str)]) -> Bench {
        let [folder, cache] = [0, 1].map(|_| tempfile::tempdir().unwrap());
        let bench = Bench { folder, cache };
        for (name, text) in files {
            bench.write(name, text);
        }
        bench
    }

    /// A path in the folder.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Writes a file, and the folders above it.
    pub fn write(&self, name: &str, text: impl AsRef<[u8]>) {
        let path = self.path(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }

    /// Reads a file.
    pub fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    /// Everything in the folder, sorted.
    pub fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(self.folder.path()).unwrap();
        let mut names: Vec<_> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    /// The program with arguments as one would type them, in the folder.
    pub fn command(&self, arguments: &str) -> Command {
        let mut command = Command::from_std(self.plain_command(arguments));
        command.timeout(Duration::from_secs(120));
        command
    }

    /// The same without a limit of its time, to be started.
    pub fn plain_command(&self, arguments: &str) -> std::process::Command {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_orogen"));
        command.current_dir(self.folder.path()).args(arguments.split_whitespace());
        command.env_remove("NO_COLOR").env("XDG_DATA_HOME", self.path("data"));
        command.env("OROGEN_CACHE", self.cache.path());
        command
    }

    /// Runs the program.
    pub fn run(&self, arguments: &str) -> Assert {
        self.command(arguments).assert()
    }

    /// Starts the program in the background.
    pub fn start(&self, arguments: &str) -> Running {
        self.start_with(arguments, &[])
    }

    /// The same in another environment.
    pub fn start_with(&self, arguments: &str, environment: &[(&str, &str)]) -> Running {
        let log = self.path("log");
        let file = fs::File::create(&log).unwrap();
        let mut command = self.plain_command(arguments);
        command.stdin(Stdio::null()).stdout(file.try_clone().unwrap()).stderr(file);
        command.envs(environment.iter().copied());
        Running { child: command.spawn().unwrap(), log }
    }

    /// Width, height and mean colour of a picture.
    pub fn picture(&self, name: &str) -> (u32, u32, [f64; 3]) {
        summary(&self.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }
}

/// Width, height and mean colour of a picture file.
pub fn summary(path: &Path) -> image::ImageResult<(u32, u32, [f64; 3])> {
    let picture = image::open(path)?.to_rgb8();
    let mut sum = [0.0; 3];
    for pixel in picture.pixels() {
        for channel in 0..3 {
            sum[channel] += f64::from(pixel[channel]);
        }
    }
    let pixels = f64::from(picture.width()) * f64::from(picture.height());
    Ok((picture.width(), picture.height(), sum.map(|s| s / pixels)))
}

/// What a run said on standard error.
pub fn stderr(assert: &Assert) -> String {
    String::from_utf8(assert.get_output().stderr.clone()).unwrap()
}

/// What a run said on standard output.
pub fn stdout(assert: &Assert) -> String {
    String::from_utf8(assert.get_output().stdout.clone()).unwrap()
}

/// Asserts that a text has all these pieces.
#[track_caller]
pub fn has(text: &str, pieces: &[&str]) {
    for piece in pieces {
        assert!(text.contains(piece), "`{piece}` is missing in:\n{text}");
    }
}

/// What a program takes of the machine.
#[derive(Clone, Copy, Debug)]
pub struct Usage {
    /// Bytes that are in memory.
    pub memory: usize,
    /// Threads.
    pub threads: usize,
    /// Open files.
    pub handles: usize,
}

/// A program in the background; it ends with the test.
pub struct Running {
    child: std::process::Child,
    log: PathBuf,
}

impl Running {
    /// What it has said.
    pub fn log(&self) -> String {
        fs::read_to_string(&self.log).unwrap()
    }

    /// Waits until something holds.
    #[track_caller]
    pub fn wait_until(&self, what: &str, mut holds: impl FnMut() -> bool) {
        let start = Instant::now();
        while !holds() {
            assert!(start.elapsed() < Duration::from_secs(60), "never came true: {what}\n{}", self.log());
            std::thread::sleep(Duration::from_millis(10));
        }
    }

    /// Waits until it has said something `n` times.
    #[track_caller]
    pub fn wait_for(&self, piece: &str, n: usize) {
        self.wait_until(piece, || self.log().matches(piece).count() >= n);
    }

    /// Presses Ctrl-C.
    pub fn interrupt(&self) {
        let id = self.child.id().to_string();
        assert!(std::process::Command::new("kill").args(["-INT", &id]).status().unwrap().success());
    }

    /// What it takes of the machine.
    #[cfg(target_os = "linux")]
    pub fn usage(&self) -> Usage {
        let folder = PathBuf::from(format!("/proc/{}", self.child.id()));
        let entries = |name: &str| fs::read_dir(folder.join(name)).unwrap().count();
        let pages = fs::read_to_string(folder.join("statm")).unwrap();
        let resident: usize = pages.split(' ').nth(1).unwrap().parse().unwrap();
        Usage { memory: 4096 * resident, threads: entries("task"), handles: entries("fd") }
    }

    /// Kills it, as a power cut would.
    pub fn kill(mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }

    /// Waits for the end, and gives the exit code and what was said.
    pub fn end(mut self) -> (Option<i32>, String) {
        let start = Instant::now();
        while start.elapsed() < Duration::from_secs(60) {
            if let Some(status) = self.child.try_wait().unwrap() {
                return (status.code(), self.log());
            }
            std::thread::sleep(Duration::from_millis(10));
        }
        panic!("does not end:\n{}", self.log());
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
