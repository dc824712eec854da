//! Words of a figure that a paper sets itself.

use super::{DotFigure, FieldFigure, Figure, Picture, Sheet};

/// Title and small print of a figure, in place of its own.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Wording {
    /// Title, in place of title and subtitle; empty for neither. `None` keeps both.
    pub title: Option<String>,
    /// Whether the figure is drawn without its small print.
    pub without_caption: bool,
}

impl Wording {
    fn change(&self, title: &mut String, subtitle: &mut String) {
        if let Some(own) = &self.title {
            title.clone_from(own);
            subtitle.clear();
        }
    }
}

impl Picture for Figure {
    fn worded(&self, wording: &Wording) -> Option<Box<dyn Picture>> {
        Sheet::from(self).worded(wording)
    }
}

impl Picture for Sheet {
    fn worded(&self, wording: &Wording) -> Option<Box<dyn Picture>> {
        let mut own = self.clone();
        wording.change(&mut own.title, &mut own.subtitle);
        if wording.without_caption {
            own.footnote = None;
        }
        Some(Box::new(own))
    }
}

impl Picture for FieldFigure {
    fn worded(&self, wording: &Wording) -> Option<Box<dyn Picture>> {
        let mut own = self.clone();
        wording.change(&mut own.title, &mut own.subtitle);
        if wording.without_caption {
            own.footnote.clear();
        }
        Some(Box::new(own))
    }
}

impl Picture for DotFigure {
    fn worded(&self, wording: &Wording) -> Option<Box<dyn Picture>> {
        let mut own = self.clone();
        wording.change(&mut own.title, &mut own.subtitle);
        if wording.without_caption {
            own.footnote.clear();
        }
        Some(Box::new(own))
    }
}
