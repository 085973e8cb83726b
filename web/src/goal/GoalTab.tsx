export default function GoalTab() {
  return <div />;
}
