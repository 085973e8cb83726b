import { Center, Loader } from "@mantine/core";
import { useTranslation } from "react-i18next";
import { Login } from "../always/Login";
import { LoginAgain } from "../always/LoginAgain";
import { Unreachable } from "../always/Unreachable";
import { useLoginEnded, useMe } from "../api/session";
import { Shell } from "./Shell";
import { useServer } from "./useServer";

/** The pages, or the login if a key is required. */
export function App() {
  const { t } = useTranslation();
  const { data: me, error } = useMe();
  const refused = useLoginEnded();
  useServer(me !== undefined && !refused);
  if (me !== undefined) {
    return (
      <>
        <Shell />
        {refused && <LoginAgain name={me.name} />}
      </>
    );
  }
  if (refused) return <Login />;
  if (error !== null) return <Unreachable error={error} />;
  return (
    <Center component="main" h="100%">
      <Loader aria-label={t("loading")} />
    </Center>
  );
}
