/** What is always there: stop-all, who is signed in, the state of the station. */
export function Header() {
  return <header />;
}
