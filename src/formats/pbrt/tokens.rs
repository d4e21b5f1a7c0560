//! Words, numbers, strings and brackets of pbrt files.

use std::borrow::Cow;

/// The smallest unit of a file.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Token<'a> {
    /// A directive, or `true` or `false`.
    Word(&'a str),
    Number(f64),
    /// A text in quotes.
    Text(Cow<'a, str>),
    Open,
    Close,
}

/// Reads the tokens of a file, and counts lines.
pub(crate) struct Tokens<'a> {
    rest: &'a str,
    /// Line of the last token, from 1.
    line: usize,
    peeked: Option<Token<'a>>,
}

impl<'a> Tokens<'a> {
    pub(crate) fn new(text: &'a str) -> Self {
        Self { rest: text, line: 1, peeked: None }
    }

    pub(crate) fn line(&self) -> usize {
        self.line
    }

    /// The next token, which remains the next one.
    pub(crate) fn peek(&mut self) -> Result<Option<&Token<'a>>, String> {
        if self.peeked.is_none() {
            self.peeked = self.read()?;
        }
        Ok(self.peeked.as_ref())
    }

    /// The next token; `None` at the end of the file.
    pub(crate) fn next(&mut self) -> Result<Option<Token<'a>>, String> {
        match self.peeked.take() {
            None => self.read(),
            token => Ok(token),
        }
    }

    fn read(&mut self) -> Result<Option<Token<'a>>, String> {
        loop {
            let blank = self.rest.trim_start();
            let skipped = &self.rest[..self.rest.len() - blank.len()];
            self.line += skipped.matches('\n').count();
            self.rest = blank;
            match blank.as_bytes().first() {
                None => return Ok(None),
                Some(b'#') => self.rest = &blank[blank.find('\n').unwrap_or(blank.len())..],
                Some(b'[') => return Ok(Some(self.take(1, Token::Open))),
                Some(b']') => return Ok(Some(self.take(1, Token::Close))),
                Some(b'"') => return self.text().map(Some),
                Some(_) => {
                    let ends = |c: char| c.is_whitespace() || "[]\"#".contains(c);
                    let (word, _) = blank.split_at(blank.find(ends).unwrap_or(blank.len()));
                    let token = match word.parse::<f64>() {
                        Ok(number) if number.is_finite() => Token::Number(number),
                        Ok(_) => return Err(format!("the number {word} is not finite")),
                        Err(_) => Token::Word(word),
                    };
                    return Ok(Some(self.take(word.len(), token)));
                }
            }
        }
    }

    fn take(&mut self, length: usize, token: Token<'a>) -> Token<'a> {
        self.rest = &self.rest[length..];
        token
    }

    /// A text that begins with a quotation mark. Lines end it, as in pbrt.
    fn text(&mut self) -> Result<Token<'a>, String> {
        let inside = &self.rest[1..];
        let mut escaped = false;
        for (i, c) in inside.char_indices() {
            match c {
                '\n' => break,
                _ if escaped => escaped = false,
                '\\' => escaped = true,
                '"' => {
                    let text = &inside[..i];
                    let text =
                        if text.contains('\\') { unescaped(text).into() } else { text.into() };
                    return Ok(self.take(i + 2, Token::Text(text)));
                }
                _ => {}
            }
        }
        Err("the text has no closing quotation mark on its line".to_owned())
    }
}

fn unescaped(text: &str) -> String {
    let mut chars = text.chars();
    let mut plain = String::new();
    while let Some(c) = chars.next() {
        plain.push(match (c, c == '\\') {
            (_, true) => match chars.next() {
                Some('n') => '\n',
                Some('t') => '\t',
                Some(other) => other,
                None => '\\',
            },
            (c, false) => c,
        });
    }
    plain
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tokens_have_kinds_and_lines() {
        let mut tokens = Tokens::new("Shape \"a\\\"b\" # [x\n [1 -2.5e1]\ntrue .5");
        let mut all = Vec::new();
        while let Some(token) = tokens.next().unwrap() {
            all.push((token, tokens.line()));
        }
        let text = |text: &str| Token::Text(text.to_owned().into());
        let want = [
            (Token::Word("Shape"), 1),
            (text("a\"b"), 1),
            (Token::Open, 2),
            (Token::Number(1.0), 2),
            (Token::Number(-25.0), 2),
            (Token::Close, 2),
            (Token::Word("true"), 3),
            (Token::Number(0.5), 3),
        ];
        assert_eq!(all, want);
        assert!(Tokens::new("\"open\n\"").next().unwrap_err().contains("no closing"));
    }
}
