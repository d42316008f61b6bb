//! What is joined with what.

/// Sets that are joined to one another, each known by its smallest member.
#[derive(Clone, Debug, Default)]
pub(super) struct Sets(Vec<u32>);

impl Sets {
    /// Sets of one, up to so many in all.
    pub fn grow(&mut self, count: usize) {
        self.0.extend(self.0.len() as u32..count as u32);
    }

    pub fn of(&mut self, mut a: u32) -> u32 {
        while self.0[a as usize] != a {
            self.0[a as usize] = self.0[self.0[a as usize] as usize];
            a = self.0[a as usize];
        }
        a
    }

    /// Joins two sets; returns whether they were two.
    pub fn join(&mut self, a: u32, b: u32) -> bool {
        let (a, b) = (self.of(a), self.of(b));
        self.0[a.max(b) as usize] = a.min(b);
        a != b
    }
}
