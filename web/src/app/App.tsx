import { Login } from "../always/Login";
import { useMe } from "../api/session";
import { Shell } from "./Shell";
import { useServer } from "./useServer";

/** The pages: of somebody who is let in, else the place to show a key. */
export function App() {
  const { data: me, error } = useMe();
  useServer(me !== undefined);
  if (me === undefined) return <Login refusal={error} />;
  return <Shell />;
}
