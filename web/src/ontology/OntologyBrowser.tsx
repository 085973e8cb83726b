export default function OntologyBrowser() {
  return null;
}
