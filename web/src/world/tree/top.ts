/** Id of the root node. */
export const TOP = "";
