//! The scripts of the tutorial, as they stand on its page.

use orogen::script::{Request, compile};
use std::path::Path;

/// The scripts of a page, in order.
fn scripts(page: &str) -> Vec<&str> {
    page.split("```rhai\n").skip(1).filter_map(|rest| rest.split("```").next()).collect()
}

#[test]
fn every_step_makes_a_scene() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs");
    let page = std::fs::read_to_string(folder.join("tutorial.md")).unwrap();
    let scripts = scripts(&page);
    assert_eq!(scripts.len(), page.matches("\n## ").count());
    for (i, script) in scripts.iter().enumerate() {
        let compiled = compile(&Request::text(*script));
        assert!(compiled.diagnostics.is_empty(), "step {}: {:?}", i + 1, compiled.diagnostics);
        assert!(compiled.scene.is_some());
        let picture = format!("tutorial/{}.png", i + 1);
        assert!(page.contains(&picture) && folder.join(&picture).exists(), "no picture of step {}", i + 1);
    }
}
