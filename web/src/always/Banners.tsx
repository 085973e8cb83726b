/** What nobody shall miss: a lost connection, a halt, alarms, questions. */
export function Banners() {
  return <div />;
}
