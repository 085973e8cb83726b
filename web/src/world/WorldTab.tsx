export default function WorldTab() {
  return <div />;
}
