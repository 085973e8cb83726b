/** Id of the node above everything. */
export const TOP = "";
