//! Does a layer in any spelling become one that the library reads, line by line?
#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

use super::*;

fn of(statement: &str) -> String {
    let text = format!("#usda 1.0\ndef \"A\"\n{{\n{statement}\n}}\n");
    let written = rewrite(&text, None).unwrap().text;
    assert_eq!(written.lines().count(), text.lines().count(), "{written}");
    let lines: Vec<&str> = written.lines().skip(3).collect();
    let words = |line: &str| line.split_whitespace().collect::<Vec<_>>().join(" ");
    words(&lines[..lines.len() - 1].join(" "))
}

#[test]
fn spellings_of_the_format_become_those_of_the_library() {
    for (written, expected) in [
        ("double x = .5", "double x = 0.5"),
        ("double2 x = (5., -.5e2) // twice", "double2 x = (5.0, -0.5e2)"),
        ("float[] x = [inf, -inf, nan,] # end", "float[] x = [1e999, -1e999, nan,]"),
        ("double /* a\n # b */ x = 1;;", "double x = 1"),
        ("int x = 1e3", "int x = 1000"),
        ("int x = 1.7", "int x = 1"),
        ("bool x = yes", "bool x = true"),
        ("bool x = 2", "bool x = true"),
        ("uint[] x = [1, 4294967295]", "int64[] x = [1, 4294967295]"),
        ("uint64[] x = [18446744073709551615]", "int64[] x = [9223372036854775807]"),
        ("asset x = \"a.png\"", "asset x = @a.png@"),
        (
            "asset x.timeSamples = { 1: @a@, 2: None, 3: 'b' }",
            "asset[] x.timeSamples = { 1: [ @a@] 2: None 3: [ @b@] }",
        ),
        ("bool x.timeSamples = { .5: true, 1: off }", "bool x.timeSamples = { 0.5: true 1: false }"),
        ("pathExpression x = '//*'", "string x = '//*'"),
        ("foo x = 5", ""),
        ("double x.spline = { bezier, 1: 5; pre (2, 1) }", ""),
        ("config custom varying rel x = </A>", "custom rel x = </A>"),
        ("rel x.default = </A>", ""),
        (
            "double x = 1 (doc = \"a\"; interpolation = 'constant', customData = { int b = 1 })",
            "double x = 1 ( interpolation = 'constant' )",
        ),
        ("string x = \"a\\\"b\"", "string x = '''a\"b'''"),
        ("double größe = 1", "double gr_u00f6__u00df_e = 1"),
    ] {
        assert_eq!(of(written), expected, "{written}");
    }
}

#[test]
fn metadata_that_has_no_effect_is_left_out_and_the_rest_stays() {
    let text = "#usda 1.1 here\n(\n \"note\"\n customData = { int a = 1 }\n metersPerUnit = .01\n)\n\
        def \"A\" (\n kind = \"group\", active = 1; prepend references = [@a@<>, </B> (scale = .5; customData = {})]\n)\n{\n}\n";
    let written = rewrite(text, None).unwrap().text;
    for kept in ["#usda 1.0\n", "metersPerUnit = 0.01", "active = true", "@a@", "</B> (scale = 0.5"] {
        assert!(written.contains(kept), "{kept}: {written}");
    }
    assert!(
        !written.contains("kind") && !written.contains("customData") && !written.contains("<>"),
        "{written}"
    );
}

#[test]
fn what_is_wrong_has_its_line() {
    for (text, line, words) in [
        ("#usda 1.0\n\ndef \"A\" {\n double = 5\n}\n", 4, "name of an attribute"),
        ("#usda 1.0\n/* a\n*/\nfed \"A\" {}\n", 4, "`def`, `over` or `class`"),
        ("#usda 1.0\ndef \"A\" {\n", 3, "`}`"),
        ("#usda 1.0\ndef \"A\" {\n int x = $\n}\n", 3, "`$`"),
        ("#usda 1.0\ndef \"A\" {\n string x = \"a\n}\n", 3, "no end"),
        ("#usda 2.0\n", 1, "#usda 1.0"),
        ("hello\n", 1, "#usda 1.0"),
        ("#usda 1.0\ndef \"A\" {\n int x = \"a\"\n}\n", 3, "a whole number"),
    ] {
        let fault = rewrite(text, None).err().unwrap();
        assert_eq!((fault.line, fault.message.contains(words)), (Some(line), true), "{text}: {fault:?}");
    }
    let deep = format!("#usda 1.0\n{}", "def \"A\" {\n".repeat(300));
    assert!(rewrite(&deep, None).err().unwrap().message.contains("nested more than 256 deep"));
    let brackets = format!("#usda 1.0\ndef \"A\" {{ int x = {}", "[".repeat(1_000_000));
    assert!(rewrite(&brackets, None).err().unwrap().message.contains("brackets within each other"));
}

#[test]
fn times_and_offsets_become_those_of_another_rate() {
    let layer = "#usda 1.0\n(\n timeCodesPerSecond = 48\n subLayers = [@a@ (offset = 12; scale = 2)]\n)\n\
        def \"A\" (references = </B> (offset = 6)) {\n double x.timeSamples = { 0: 1, 24: 2 }\n}\n";
    let written = rewrite(layer, Some(24.0)).unwrap().text;
    for expected in
        ["timeCodesPerSecond = 24", "offset = 6.0", "scale = 2", "offset = 3.0", "0.0: 1  12.0: 2"]
    {
        assert!(written.contains(expected), "{expected}: {written}");
    }
    assert!(!written.contains("48") && written.lines().count() == layer.lines().count(), "{written}");
    // a layer that says nothing has 24
    let written =
        rewrite("#usda 1.0\n\ndef \"A\" { double x.timeSamples = { 24: 2 } }\n", Some(48.0)).unwrap().text;
    assert!(written.contains("(timeCodesPerSecond = 48)") && written.contains("48.0: 2"), "{written}");
    assert_eq!(written.lines().count(), 3);
}
