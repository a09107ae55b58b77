//! A RON text as a tree of its fields and values, whatever they mean: for what is looked up by name.

use super::ron_tokens::{Token, Tokens};
use std::ops::Range;

/// Deepest nesting that is searched: twice what any document of the program has.
const MAX_DEPTH: usize = 32;

/// A value, or what there is of one.
#[derive(Clone, Debug)]
pub(super) enum Node {
    Fields(Vec<Field>),
    Items(Vec<Node>),
    /// Where its digits stand.
    Number(Range<usize>),
    Text(String),
    /// Of a variant without content, `true`, `inf`.
    Word(String),
    /// No value, or one that is too deep.
    Nothing,
}

/// A field of a struct or of a variant.
#[derive(Clone, Debug)]
pub(super) struct Field {
    pub name: String,
    /// Where its name begins.
    pub at: usize,
    pub value: Node,
}

impl Node {
    /// The value that a text is; any text is some.
    pub(super) fn of(text: &str) -> Self {
        Parser { text, tokens: Tokens::of(text).collect(), at: 0, depth: 0 }.node()
    }

    /// What is within `Some(…)`, or a list of one.
    pub(super) fn inner(&self) -> &Self {
        match self {
            Self::Items(items) if items.len() == 1 => items[0].inner(),
            _ => self,
        }
    }

    /// Its fields, or those within it; none of what has none.
    pub(super) fn fields(&self) -> &[Field] {
        match self.inner() {
            Self::Fields(fields) => fields,
            _ => &[],
        }
    }

    /// The value of one of them.
    pub(super) fn field(&self, name: &str) -> Option<&Self> {
        self.fields().iter().find(|field| field.name == name).map(|field| &field.value)
    }
}

/// Reads on from the tokens of a text.
struct Parser<'a> {
    text: &'a str,
    tokens: Vec<(Token, Range<usize>)>,
    at: usize,
    depth: usize,
}

impl Parser<'_> {
    fn peek(&self) -> Option<Token> {
        self.tokens.get(self.at).map(|(token, _)| *token)
    }

    fn node(&mut self) -> Node {
        let Some((token, range)) = self.tokens.get(self.at).cloned() else {
            return Node::Nothing;
        };
        self.at += 1;
        match token {
            Token::Number => Node::Number(range),
            Token::Quoted => Node::Text(self.text[range].trim_matches('"').replace("\\\"", "\"")),
            Token::Sign('(' | '[' | '{') => self.group(),
            // What stands before parentheses is the name of their kind.
            Token::Word if self.peek() == Some(Token::Sign('(')) => {
                self.at += 1;
                self.group()
            }
            Token::Word => Node::Word(self.text[range].to_owned()),
            Token::Sign(_) | Token::Comment => Node::Nothing,
        }
    }

    fn group(&mut self) -> Node {
        if self.depth == MAX_DEPTH {
            return Node::Nothing;
        }
        self.depth += 1;
        let (mut fields, mut items) = (Vec::new(), Vec::new());
        while let Some((token, range)) = self.tokens.get(self.at).cloned() {
            let next = self.tokens.get(self.at + 1).map(|(next, _)| *next);
            match token {
                Token::Sign(')' | ']' | '}') => {
                    self.at += 1;
                    break;
                }
                Token::Sign(',') => self.at += 1,
                Token::Word if next == Some(Token::Sign(':')) => {
                    self.at += 2;
                    let (at, name) = (range.start, self.text[range].to_owned());
                    fields.push(Field { name, at, value: self.node() });
                }
                _ => items.push(self.node()),
            }
        }
        self.depth -= 1;
        if fields.is_empty() { Node::Items(items) } else { Node::Fields(fields) }
    }
}
