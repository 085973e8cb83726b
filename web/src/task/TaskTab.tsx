export default function TaskTab() {
  return <div />;
}
