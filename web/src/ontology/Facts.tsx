import { DataList, Text, Title } from "@mantine/core";
import type { ReactNode } from "react";

interface HeadProps {
  name: string;
  label: string;
  comment: string;
}

export function Head({ name, label, comment }: HeadProps) {
  return (
    <div>
      <Title order={3} size="h5">
        {label}
      </Title>
      <Text size="xs" c="dimmed">
        {name}
      </Text>
      <Text size="sm" mt={4}>
        {comment}
      </Text>
    </div>
  );
}

export function Facts({ children }: { children: ReactNode }) {
  return (
    <DataList size="sm" labelWidth={120}>
      {children}
    </DataList>
  );
}

export function Fact({ label, children }: { label: string; children: ReactNode }) {
  return (
    <DataList.Item>
      <DataList.ItemLabel>{label}</DataList.ItemLabel>
      <DataList.ItemValue>{children}</DataList.ItemValue>
    </DataList.Item>
  );
}
