export default function ModulesTab() {
  return <div />;
}
