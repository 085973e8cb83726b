/** Whether the page is used by touch, where controls are larger; `app.css` has the same for those it draws. */
export const TOUCH = typeof matchMedia === "function" && matchMedia("(pointer: coarse)").matches;
