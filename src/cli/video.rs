//! `orogen video`: the frames of an animation to a video, by ffmpeg.
//!
//! Frames whose numbers follow one another are read by ffmpeg; of a sequence with a step it is given the files one after
//! another, since it knows no steps.
//!
//! Frames are sRGB. ffmpeg turns them into what players expect: H.264 in blocks of 2x2 colours, with the matrix of
//! Rec. 709 and a header that says so; a picture of odd size gets a black edge. (Without being told, ffmpeg takes the
//! older matrix of Rec. 601 and does not say so, and greens and reds shift.)

use super::frames::{self, Frames, Pattern};
use super::interrupt::{Flag, Interrupt};
use super::progress::Progress;
use super::report::{Failure, Outcome, Terminal, err, plural, word};
use crate::diag::Diagnostic;
use crate::world::atomic;
use std::ffi::OsString;
use std::fs::File;
use std::io::{self, BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStderr, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Duration;

/// Make a video of frames
///
/// It needs ffmpeg (https://ffmpeg.org) on the PATH; without it, it says which command to run where there is one. All frames
/// that match the pattern are taken, and their numbers must follow one another; three or more may be as far apart
/// everywhere, as of `--frames 1-250:5`. The frames are kept. The video is written whole or not at all.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  orogen render rock.rhai --frames 1-250           the frames, rock.0001.png and so on
  orogen video 'rock.####.png' -o rock.mp4         10 seconds of them
  orogen video 'out/rock.###.png' -o rock.mkv --fps 30 --quality 14")]
pub struct Args {
    /// Frames, .png, with a row of # where the number is, as `orogen render --frames` names them
    #[arg(value_name = "PATTERN")]
    pattern: PathBuf,

    /// Video to write, .mp4, .mov or .mkv
    #[arg(short, long, value_name = "FILE", value_parser = container)]
    output: Output,

    /// Frames a second
    #[arg(long, value_name = "F", default_value = "25", value_parser = frames::rate, allow_negative_numbers = true)]
    fps: f64,

    /// H.264's constant rate factor: smaller is better and larger, 18 looks like the frames
    #[arg(long, value_name = "CRF", default_value_t = 18, value_parser = clap::value_parser!(u8).range(0..=51))]
    quality: u8,
}

/// A file and ffmpeg's name of its format.
#[derive(Clone, Debug)]
struct Output {
    path: PathBuf,
    format: &'static str,
}

/// Parses the name of a video.
fn container(text: &str) -> Result<Output, String> {
    let path = PathBuf::from(text);
    let ending = path.extension().unwrap_or_default().to_ascii_lowercase();
    let format = [("mp4", "mp4"), ("mov", "mov"), ("mkv", "matroska")].into_iter().find(|f| ending == f.0);
    match format {
        Some((_, format)) => Ok(Output { path, format }),
        None => Err("it does not end in .mp4, .mov or .mkv; for example: -o rock.mp4".into()),
    }
}

/// Runs the command.
pub fn run(args: &Args, terminal: &Terminal) -> Outcome {
    if !args.pattern.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("png")) {
        let hint = format!("for example: {}", args.pattern.with_extension("png").display());
        return Err(Failure::usage("frames of a video are .png files", hint));
    }
    let pattern = Pattern::of(&args.pattern)?;
    let (frames, count) = sequence(&pattern, &args.pattern)?;
    let progress = Progress::new(terminal, &args.output.path.display().to_string());
    let flag = Interrupt::stopping(&progress).flag();
    check(&pattern, frames, &flag).inspect_err(|_| progress.finish())?;
    let mut missing = false;
    let made = atomic::write_by(&args.output.path, |temporary| {
        let mut command = Command::new("ffmpeg");
        command.args(["-progress", "pipe:1"]).args(arguments(args, &pattern, (frames, count), temporary));
        let given = if frames.are_consecutive() { Stdio::null() } else { Stdio::piped() };
        command.stdin(given).stdout(Stdio::piped()).stderr(Stdio::piped());
        let child = command.spawn();
        missing = child.as_ref().is_err_and(|e| e.kind() == io::ErrorKind::NotFound);
        let files = frames.numbers().map(|number| pattern.path(number)).collect();
        let shown = follow(child?, files, &flag, |done| progress.set(done as f64 / count as f64))?;
        // It leaves out what it cannot read, and says that all went well.
        if shown == count {
            return Ok(());
        }
        Err(io::Error::other(format!("ffmpeg took {shown} of the {}", plural(count, "frame"))))
    });
    progress.finish();
    match made {
        Ok(()) => {
            let left_out = match frames.step() {
                1 => String::new(),
                step => format!(", one in {step},"),
            };
            let (file, count) = (args.output.path.display(), plural(count, "frame"));
            err(format!("{file}: {count}{left_out} at {} a second", args.fps));
            Ok(())
        }
        Err(_) if missing => {
            let command = line(&arguments(args, &pattern, (frames, count), &args.output.path));
            let given = if frames.are_consecutive() {
                ""
            } else {
                ", with the frames one after another as its input"
            };
            let hint = format!("install it (https://ffmpeg.org), or run where it is{given}: {command}");
            Err(Failure::error("there is no ffmpeg on the PATH, which makes the video", hint))
        }
        Err(_) if flag.load(Ordering::Relaxed) => Err(Failure::error(
            "stopped before the video was finished",
            "no file was written; the frames are there",
        )),
        Err(error) => Err(Diagnostic::error(error.to_string()).into()),
    }
}

/// Which frames there are.
fn sequence(pattern: &Pattern, shown: &Path) -> Result<(Frames, u64), Failure> {
    let numbers = pattern.numbers().map_err(|e| {
        let message = format!("cannot read the folder of {} ({e})", shown.display());
        Failure::error(message, "check its name and permissions")
    })?;
    let Some(frames) = Frames::through(&numbers) else {
        let hint = "make them with: orogen render SCRIPT --frames A-B";
        return Err(Failure::error(format!("there are no frames called {}", shown.display()), hint));
    };
    if let Some((missing, _)) = frames.numbers().zip(&numbers).find(|(expected, number)| expected != *number)
    {
        let message = format!("frame {missing} is missing: there is no {}", pattern.path(missing).display());
        let hint = "render it; for fewer frames a second, render all frames with a smaller --fps";
        return Err(Failure::error(message, hint));
    }
    Ok((frames, numbers.len() as u64))
}

/// Gives files to ffmpeg, one after another, until it takes no more.
fn feed(mut input: ChildStdin, files: &[PathBuf]) -> io::Result<()> {
    for file in files {
        match File::open(file).and_then(|mut file| io::copy(&mut file, &mut input)) {
            Err(error) if error.kind() == io::ErrorKind::BrokenPipe => break,
            given => given?,
        };
    }
    Ok(())
}

/// Reads all frames, so that none is left out or stretched in silence: ffmpeg goes on without those that are damaged, and
/// brings the others to the size of the first.
fn check(pattern: &Pattern, frames: Frames, flag: &Flag) -> Outcome {
    let mut all = None;
    for number in frames.numbers() {
        if flag.load(Ordering::Relaxed) {
            return Err(Failure::error("stopped before the video was begun", "no file was written"));
        }
        let path = pattern.path(number);
        let size = size(&path).map_err(|e| {
            let message = format!("{} is damaged, or no picture ({e})", path.display());
            Failure::error(
                message,
                "make it again: `orogen render --frames` makes those again that are damaged",
            )
        })?;
        let [width, height] = *all.get_or_insert(size);
        if size != [width, height] {
            let [w, h] = size;
            let message =
                format!("{} has {w} x {h} pixels, and the frames before {width} x {height}", path.display());
            return Err(Failure::error(message, "render all frames with one --size"));
        }
    }
    Ok(())
}

/// Width and height of a picture that is read to its end.
fn size(path: &Path) -> io::Result<[u32; 2]> {
    let mut reader = png::Decoder::new(BufReader::new(File::open(path)?)).read_info()?;
    let held = reader.output_buffer_size().ok_or(io::ErrorKind::OutOfMemory)?;
    reader.next_frame(&mut vec![0; held])?;
    reader.finish()?;
    Ok([reader.info().width, reader.info().height])
}

/// What ffmpeg is to do.
fn arguments(args: &Args, pattern: &Pattern, (frames, count): (Frames, u64), output: &Path) -> Vec<OsString> {
    let (first, numbered) = (frames.first(), frames.are_consecutive());
    let format =
        if numbered { format!("-start_number {first}") } else { "-f image2pipe -c:v png".to_owned() };
    let input = [
        "-hide_banner -loglevel error -nostdin -y".to_owned(),
        format!("-framerate {} {format} -i", args.fps),
    ];
    let encoding = [
        format!("-frames:v {count} -c:v libx264 -preset slow -crf {}", args.quality),
        "-vf pad=ceil(iw/2)*2:ceil(ih/2)*2,scale=out_color_matrix=bt709:out_range=tv,format=yuv420p"
            .to_owned(),
        "-colorspace bt709 -color_primaries bt709 -color_trc bt709 -color_range tv".to_owned(),
        format!("-f {}", args.output.format),
    ];
    let words = |pieces: &[String]| -> Vec<OsString> {
        pieces.iter().flat_map(|piece| piece.split(' ')).map(OsString::from).collect()
    };
    let mut all = words(&input);
    all.push(if numbered { pattern.printf().into() } else { "pipe:0".into() });
    all.extend(words(&encoding));
    all.push(output.into());
    all
}

/// Waits for ffmpeg, and says how far it is; ends it when the flag is raised, whatever it is waiting for. Returns how many
/// frames it has taken.
///
/// What reads from it and writes to it has threads of its own, which nobody waits for: a program that it has begun may keep
/// its pipes open.
fn follow(mut child: Child, given: Vec<PathBuf>, flag: &Flag, told: impl Fn(u64)) -> io::Result<u64> {
    let shown = Arc::new(AtomicU64::new(0));
    let complained = Arc::new(AtomicBool::new(false));
    let (told_of, is_told) = (child.stderr.take(), complained.clone());
    let relaying = told_of.map(|text| thread::spawn(move || relay(text, &is_told)));
    let (said, count) = (child.stdout.take(), shown.clone());
    let counting = said.map(|said| thread::spawn(move || self::count(said, &count)));
    let feeding = child.stdin.take().map(|input| thread::spawn(move || feed(input, &given)));
    let status = loop {
        if flag.load(Ordering::Relaxed) {
            // That fails where it has ended already.
            let _ = child.kill();
            break child.wait()?;
        }
        if let Some(status) = child.try_wait()? {
            break status;
        }
        told(shown.load(Ordering::Relaxed));
        thread::sleep(LOOK);
    };
    // Its last words may be on their way.
    for _ in 0..LAST_WORDS {
        let is_heard = relaying.as_ref().is_none_or(JoinHandle::is_finished);
        if is_heard && counting.as_ref().is_none_or(JoinHandle::is_finished) {
            break;
        }
        thread::sleep(LOOK);
    }
    if let Some(Ok(Err(error))) = feeding.filter(JoinHandle::is_finished).map(JoinHandle::join) {
        return Err(io::Error::other(format!("a frame cannot be read any more ({error})")));
    }
    // Where the disk is full it says so, and that all went well.
    match (status.success(), complained.load(Ordering::Relaxed)) {
        (true, false) => Ok(shown.load(Ordering::Relaxed)),
        (true, true) => Err(io::Error::other("ffmpeg failed; what it says is above")),
        _ => Err(io::Error::other(format!("ffmpeg failed with {status}; what it says is above"))),
    }
}

/// Passes on what is said of errors, and notes that there was something.
fn relay(told: ChildStderr, any: &AtomicBool) {
    for line in BufReader::new(told).lines().map_while(Result::ok) {
        any.store(true, Ordering::Relaxed);
        err(line);
    }
}

/// Reads how many frames were taken in lines such as `frame=17`.
fn count(said: ChildStdout, shown: &AtomicU64) {
    for line in BufReader::new(said).lines().map_while(Result::ok) {
        if let Some(frames) = line.strip_prefix("frame=").and_then(|n| n.trim().parse().ok()) {
            shown.store(frames, Ordering::Relaxed);
        }
    }
}

/// Time between two looks at the flag.
const LOOK: Duration = Duration::from_millis(20);

/// Looks for what ffmpeg has said when it has ended.
const LAST_WORDS: u32 = 50;

/// The command as one types it.
fn line(arguments: &[OsString]) -> String {
    let words: Vec<String> = arguments.iter().map(|w| word(&w.to_string_lossy())).collect();
    format!("ffmpeg {}", words.join(" "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_can_be_typed() {
        let words = ["-i", "a b/%04d.png", "it's.mp4"].map(OsString::from);
        assert_eq!(line(&words), r"ffmpeg -i 'a b/%04d.png' 'it'\''s.mp4'");
    }
}
