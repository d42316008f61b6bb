//! Which pictures a terminal shows: what it says of itself in the environment, and what it answers when asked.

use super::Way;
use super::terminal::Answer;

/// The way that the environment names; `None` if the terminal has to be asked.
pub fn by_environment(variable: impl Fn(&str) -> Option<String>) -> Option<Way> {
    let get = |name: &str| variable(name).unwrap_or_default();
    let (term, program) = (get("TERM"), get("TERM_PROGRAM"));
    if term == "dumb" {
        return Some(Way::None);
    }
    // Variables of the terminal outside of it reach into a multiplexer; pictures do not.
    if !get("TMUX").is_empty()
        || !get("STY").is_empty()
        || term.starts_with("screen")
        || term.starts_with("tmux")
    {
        return None;
    }
    if term.contains("kitty")
        || term.contains("ghostty")
        || !get("KITTY_WINDOW_ID").is_empty()
        || program == "ghostty"
    {
        return Some(Way::Kitty);
    }
    if matches!(program.as_str(), "iTerm.app" | "WezTerm" | "mintty") || get("LC_TERMINAL") == "iTerm2" {
        return Some(Way::Iterm);
    }
    (term.starts_with("foot") || term.starts_with("mlterm")).then_some(Way::Sixel)
}

/// The way that follows from what the terminal answered.
pub fn by_answer(answer: &Answer) -> Way {
    match answer {
        Answer { kitty: true, .. } => Way::Kitty,
        Answer { sixel: true, .. } => Way::Sixel,
        _ => Way::Blocks,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(variables: &[(&str, &str)]) -> Option<Way> {
        by_environment(|name| variables.iter().find(|v| v.0 == name).map(|v| v.1.to_owned()))
    }

    #[test]
    fn terminals_are_known_by_their_variables() {
        assert_eq!(of(&[("TERM", "xterm-kitty")]), Some(Way::Kitty));
        assert_eq!(of(&[("TERM", "xterm-256color"), ("TERM_PROGRAM", "iTerm.app")]), Some(Way::Iterm));
        assert_eq!(of(&[("TERM", "foot-extra")]), Some(Way::Sixel));
        assert_eq!(of(&[("TERM", "dumb"), ("KITTY_WINDOW_ID", "1")]), Some(Way::None));
        assert_eq!(of(&[("TERM", "xterm-256color")]), None);
        assert_eq!(of(&[("TERM", "tmux-256color"), ("KITTY_WINDOW_ID", "1")]), None);
        assert_eq!(of(&[("TERM", "xterm-kitty"), ("TMUX", "/tmp/x")]), None);
    }

    #[test]
    fn answers_choose_the_best() {
        assert_eq!(by_answer(&Answer { kitty: true, sixel: true }), Way::Kitty);
        assert_eq!(by_answer(&Answer { kitty: false, sixel: true }), Way::Sixel);
        assert_eq!(by_answer(&Answer::default()), Way::Blocks);
    }
}
