import { render } from "@testing-library/react";
import { usePrintedAlone } from "./printing";

function Report() {
  usePrintedAlone("report", "Report of kit");
  return <p id="report">all went well</p>;
}

test("only the report is printed, in light colours, and the page is restored afterwards", () => {
  const root = document.documentElement;
  root.setAttribute("data-mantine-color-scheme", "dark");
  const { unmount } = render(<Report />);
  window.dispatchEvent(new Event("beforeprint"));
  window.dispatchEvent(new Event("beforeprint")); // browsers may send it twice
  const copies = document.querySelectorAll(".print-only");
  expect([...copies].map(({ textContent }) => textContent)).toEqual(["Report of kitall went well"]);
  expect(root.getAttribute("data-mantine-color-scheme")).toBe("light");
  window.dispatchEvent(new Event("afterprint"));
  expect(document.querySelector(".print-only")).toBeNull();
  expect(root.getAttribute("data-mantine-color-scheme")).toBe("dark");
  unmount();
  window.dispatchEvent(new Event("beforeprint"));
  expect(document.querySelector(".print-only")).toBeNull();
});
