export default function QueryConsole() {
  return null;
}
