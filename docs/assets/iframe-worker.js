// Search in a page opened from a folder. Browsers refuse workers there (file://), so the search runs in a hidden frame.
if (location.protocol === "file:") {
  window.Worker = class extends EventTarget {
    constructor(url) {
      super()
      const base = new URL(url, location.href)
      this.waiting = []
      const frame = document.createElement("iframe")
      frame.hidden = true
      document.body.appendChild(frame)
      frame.contentDocument.open() // a document of our own, which the browser does not replace
      frame.contentDocument.write("<body></body>")
      frame.contentDocument.close()
      const scope = frame.contentWindow
      const load = (address) =>
        new Promise((resolve, reject) => {
          const script = scope.document.createElement("script")
          script.src = new URL(address, base).href
          script.onload = resolve
          script.onerror = () => reject(new Error(`cannot load ${address}`))
          scope.document.body.appendChild(script)
        })
      scope.importScripts = (...addresses) =>
        addresses.reduce((before, address) => before.then(() => load(address)), Promise.resolve())
      scope.postMessage = (data) => this.dispatchEvent(new MessageEvent("message", { data }))
      load(base).then(() => {
        const waiting = this.waiting
        this.waiting = null
        this.scope = scope
        waiting.forEach((data) => this.postMessage(data))
      })
    }

    postMessage(data) {
      if (this.waiting) this.waiting.push(data)
      else this.scope.dispatchEvent(new this.scope.MessageEvent("message", { data }))
    }

    terminate() {}
  }
}
