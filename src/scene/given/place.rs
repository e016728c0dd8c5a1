//! Tells a table of a shot file by its name instead of its line.

/// Names the table that holds `line` (from 1) of `text`, for the beginning of a message: ``material `Gold`: ``. Empty outside of tables.
pub fn place_in(text: &str, line: usize) -> String {
    let lines: Vec<&str> = text.lines().collect();
    let is_header = |line: &&&str| line.starts_with('[');
    let Some(begin) = lines.iter().take(line).rposition(|line| is_header(&line)) else {
        return String::new();
    };
    let header = lines[begin];
    let table = header.trim_matches(['[', ']']);
    let is_of_list = header.starts_with("[[");
    let own = lines[begin + 1..].iter().take_while(|line| !is_header(line));
    let name = own.filter_map(|line| line.strip_prefix("name = ")).next().filter(|_| is_of_list);
    let number = lines[..=begin].iter().filter(|line| **line == header).count();
    match name {
        Some(name) => format!("{table} `{}`: ", name.trim_matches('"')),
        None if is_of_list => format!("{table} {number}: "),
        None => format!("{table}: "),
    }
}
