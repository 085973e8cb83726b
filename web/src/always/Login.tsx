/** Where somebody shows a key. */
export function Login({ refusal }: { refusal: unknown }) {
  return <main>{refusal instanceof Error ? refusal.message : ""}</main>;
}
