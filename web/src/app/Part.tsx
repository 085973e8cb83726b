import { Alert, Button, Loader, Stack } from "@mantine/core";
import { QueryErrorResetBoundary } from "@tanstack/react-query";
import { Component, type ReactNode, Suspense } from "react";
import { useTranslation } from "react-i18next";

interface Props {
  children: ReactNode;
}

/** A part of the page that may load late or fail without affecting the rest, above all the stop button. */
export function Part({ children }: Props) {
  return (
    <QueryErrorResetBoundary>
      <Boundary>
        <Suspense fallback={<Waiting />}>{children}</Suspense>
      </Boundary>
    </QueryErrorResetBoundary>
  );
}

class Boundary extends Component<Props, { error: Error | null }> {
  override state: { error: Error | null } = { error: null };

  static getDerivedStateFromError(error: Error) {
    return { error };
  }

  override render() {
    const { error } = this.state;
    if (error === null) return this.props.children;
    return <Broken error={error} again={() => this.setState({ error: null })} />;
  }
}

function Broken({ error, again }: { error: Error; again: () => void }) {
  const { t } = useTranslation();
  return (
    <Alert color="red" title={t("broken.title")} m="md">
      <Stack align="start">
        {t("broken.text", { message: error.message })}
        <Button onClick={again}>{t("retry")}</Button>
      </Stack>
    </Alert>
  );
}

function Waiting() {
  const { t } = useTranslation();
  return <Loader m="md" size="sm" aria-label={t("loading")} />;
}
