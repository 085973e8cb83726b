/** The labels of the picture, by the ids of the elements that they are for; they are moved once a frame. */

export const labelNodes = new Map<string, HTMLElement>();
