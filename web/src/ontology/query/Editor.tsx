import { autocompletion, type CompletionContext, completionKeymap } from "@codemirror/autocomplete";
import { defaultKeymap, history, historyKeymap } from "@codemirror/commands";
import { bracketMatching, syntaxHighlighting } from "@codemirror/language";
import { EditorState } from "@codemirror/state";
import { drawSelection, EditorView, keymap, lineNumbers } from "@codemirror/view";
import { SparqlLanguage, sparql } from "codemirror-lang-sparql";
import { useEffect, useRef } from "react";
import { COLOURS } from "./colours";
import classes from "./Editor.module.css";

interface Props {
  label: string;
  value: string;
  onChange: (value: string) => void;
  /** Ctrl or Cmd and Enter. */
  onRun: () => void;
  /** Names for completion. */
  names: readonly string[];
  /** Position of the error; the cursor goes there. */
  error: { line: number; column: number } | null;
}

/** An editor for SPARQL queries. */
export function Editor({ label, value, onChange, onRun, names, error }: Props) {
  const host = useRef<HTMLDivElement>(null);
  const view = useRef<EditorView>(null);
  const latest = useRef({ onChange, onRun, names, value });
  useEffect(() => {
    latest.current = { onChange, onRun, names, value };
  });
  useEffect(() => {
    if (host.current === null) return;
    const editor = new EditorView({ parent: host.current, state: stateOf(label, latest) });
    view.current = editor;
    return () => editor.destroy();
  }, [label]);
  useEffect(() => {
    const editor = view.current;
    if (editor === null || editor.state.doc.toString() === value) return;
    editor.dispatch({ changes: { from: 0, to: editor.state.doc.length, insert: value } });
  }, [value]);
  useEffect(() => {
    if (view.current !== null && error !== null) goTo(view.current, error);
  }, [error]);
  return <div ref={host} className={classes.editor} />;
}

type Latest = React.RefObject<Pick<Props, "onChange" | "onRun" | "names" | "value">>;

function stateOf(label: string, latest: Latest): EditorState {
  const run = () => {
    latest.current.onRun();
    return true;
  };
  const offer = (context: CompletionContext) => {
    const word = context.matchBefore(/[\w:]+/);
    if (word === null && !context.explicit) return null;
    const options = latest.current.names.map((name) => ({ label: name }));
    return { from: word?.from ?? context.pos, options, validFor: /^[\w:]*$/ };
  };
  return EditorState.create({
    doc: latest.current.value,
    extensions: [
      keymap.of([{ key: "Mod-Enter", run }, ...completionKeymap, ...historyKeymap, ...defaultKeymap]),
      lineNumbers(),
      history(),
      drawSelection(),
      bracketMatching(),
      syntaxHighlighting(COLOURS),
      sparql(),
      SparqlLanguage.data.of({ autocomplete: offer }),
      autocompletion(),
      EditorView.lineWrapping,
      EditorView.contentAttributes.of({ "aria-label": label }),
      EditorView.updateListener.of(({ docChanged, state }) => {
        if (docChanged) latest.current.onChange(state.doc.toString());
      }),
    ],
  });
}

function goTo(view: EditorView, { line, column }: { line: number; column: number }): void {
  const { doc } = view.state;
  const { from, to } = doc.line(Math.min(Math.max(line, 1), doc.lines));
  view.dispatch({ selection: { anchor: Math.min(from + column - 1, to) }, scrollIntoView: true });
  view.focus();
}
